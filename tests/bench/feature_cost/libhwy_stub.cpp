// SPDX-License-Identifier: Apache-2.0
// Takes the place of libhwy in programs that run under valgrind. It has the one function that the
// core calls, and answers for a processor with AVX2, which is what valgrind shows them.
#include <cstdint>

namespace hwy {

// Highway 1.0's numbers of AVX2, SSE4, SSSE3, EMU128 and SCALAR.
[[gnu::visibility("default")]] std::int64_t SupportedTargets();
std::int64_t SupportedTargets() {
  return std::int64_t{1} << 9 | std::int64_t{1} << 11 | std::int64_t{1} << 12 |
         std::int64_t{1} << 61 | std::int64_t{1} << 62;
}

}  // namespace hwy
