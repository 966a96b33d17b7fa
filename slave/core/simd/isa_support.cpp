// Which instruction sets this CPU and build have: Highway's names mapped to Tessera's.
#include "hwy/targets.h"
#include "slave/core/kernel/kernel_table.h"
#include "slave/core/render/tile_renderer.h"

namespace tessera::core {
namespace {

struct Mapping {
  std::int64_t target;
  Isa isa;
};
constexpr Mapping kMappings[] = {
    {HWY_AVX3, Isa::kAvx512}, {HWY_AVX2, Isa::kAvx2}, {HWY_SSE4, Isa::kSse4}};

}  // namespace

IsaMask supported_isas() {
  const std::int64_t on_this_cpu = hwy::SupportedTargets();
  IsaMask mask = isa_bit(Isa::kScalar);
  for (const Mapping& m : kMappings) {
    if ((on_this_cpu & m.target) != 0) mask |= isa_bit(m.isa);
  }
  return mask & compiled_isas();
}

}  // namespace tessera::core
