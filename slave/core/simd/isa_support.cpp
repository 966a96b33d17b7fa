// SPDX-License-Identifier: Apache-2.0
#include "slave/core/simd/isa_support.h"

#include "hwy/targets.h"

namespace tessera::core {
namespace {

struct Mapping {
  std::int64_t target;
  Isa isa;
};
constexpr Mapping kMappings[] = {
    {HWY_AVX3, Isa::kAvx512}, {HWY_AVX2, Isa::kAvx2}, {HWY_SSE4, Isa::kSse4}};

// Asking the processor leaves a virtual machine for its host each time.
IsaMask ask_the_cpu() {
  const std::int64_t on_this_cpu = hwy::SupportedTargets();
  IsaMask mask = isa_bit(Isa::kScalar);
  for (const Mapping& m : kMappings) {
    if ((on_this_cpu & m.target) != 0) mask |= isa_bit(m.isa);
  }
  return mask;
}

}  // namespace

IsaMask cpu_isas() {
  static const IsaMask mask = ask_the_cpu();
  return mask;
}

}  // namespace tessera::core
