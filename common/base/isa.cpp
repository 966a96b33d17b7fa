// SPDX-License-Identifier: Apache-2.0
#include "common/base/isa.h"

#include <string>

#include "common/base/check.h"

namespace tessera {
namespace {
constexpr std::string_view kNames[] = {"scalar", "sse4", "avx2", "avx512"};
}

std::string_view isa_name(Isa isa) { return kNames[static_cast<int>(isa)]; }

Result<Isa> parse_isa(std::string_view text) {
  for (int i = 0; i < 4; ++i) {
    if (text == kNames[i]) return static_cast<Isa>(i);
  }
  return Status::invalid_argument("--isa " + std::string(text) +
                                  ": give one of auto, scalar, sse4, avx2, avx512");
}

Isa widest_isa(IsaMask mask) {
  TESSERA_CHECK((mask & kIsaMaskAll) != 0);
  int isa = 3;
  while ((mask >> isa & 1u) == 0) --isa;
  return static_cast<Isa>(isa);
}

}  // namespace tessera
