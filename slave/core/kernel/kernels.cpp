// All kernels, compiled once per instruction set by Highway and reached through KernelTable.
// Nothing but hwy/, -inl.h, _layout.h and C headers may be included before the table. The project
// is built with -ffp-contract=off and the kernels use no fused multiply-add, so every set computes
// the same bits.
//
// Targets: SSSE3 and the Ice Lake variant of AVX-512 have no name in Isa. The fallback is to be
// HWY_SCALAR with every compiler, one lane, and not Highway's emulation of 128 bits.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#define HWY_BROKEN_EMU128 1

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernel/kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernel/traverse-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

void trace_closest(const SceneView& scene, const RayBundle& rays, HitBundle& hits) {
  Tracer<false> tracer(scene, rays);
  tracer.run();
  tracer.store(hits);
}

uint32_t trace_occluded(const SceneView& scene, const RayBundle& rays) {
  Tracer<true> tracer(scene, rays);
  tracer.run();
  return tracer.blocked();
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "common/base/check.h"
#include "slave/core/kernel/kernel_table.h"

namespace tessera::core {
namespace {

constexpr KernelTable kTables[] = {
    {Isa::kScalar, 1, N_SCALAR::trace_closest, N_SCALAR::trace_occluded},
#if HWY_TARGETS & HWY_SSE4
    {Isa::kSse4, 4, N_SSE4::trace_closest, N_SSE4::trace_occluded},
#endif
#if HWY_TARGETS & HWY_AVX2
    {Isa::kAvx2, 8, N_AVX2::trace_closest, N_AVX2::trace_occluded},
#endif
#if HWY_TARGETS & HWY_AVX3
    {Isa::kAvx512, 16, N_AVX3::trace_closest, N_AVX3::trace_occluded},
#endif
};

}  // namespace

const KernelTable& kernels_for(Isa isa) {
  for (const KernelTable& table : kTables) {
    if (table.isa == isa) return table;
  }
  TESSERA_CHECK(false && "instruction set not compiled in");
  return kTables[0];
}

IsaMask compiled_isas() {
  IsaMask mask = 0;
  for (const KernelTable& table : kTables) mask |= isa_bit(table.isa);
  return mask;
}

}  // namespace tessera::core

#endif  // HWY_ONCE
