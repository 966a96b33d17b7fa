// SPDX-License-Identifier: Apache-2.0
// Sizes as a person reads them.
// Threads. Pure function.
#pragma once

#include <cstdint>
#include <string>

namespace tessera {

// `bytes` in MiB, rounded up so that no need is ever understated.
inline std::string mib_text(std::uint64_t bytes) {
  constexpr std::uint64_t kMib = std::uint64_t{1} << 20;
  return std::to_string(bytes / kMib + (bytes % kMib != 0 ? 1 : 0)) + " MiB";
}

}  // namespace tessera
