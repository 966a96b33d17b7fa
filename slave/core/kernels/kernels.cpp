// SPDX-License-Identifier: Apache-2.0
// All kernels but those of structures and BSDFs (bvh_kernels.cpp and others), compiled once per
// instruction set by Highway and reached through KernelTable.
// Nothing but hwy/, -inl.h, _layout.h and C headers may be included before the table. The project
// is built with -ffp-contract=off and what is reported uses no fused multiply-add, so every set
// computes the same bits.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/camera/camera-inl.h"
#include "slave/core/light/emitter-inl.h"
#include "slave/core/light/irradiance_filter-inl.h"
#include "slave/core/light/sky-inl.h"
#include "slave/core/light/vpl_gather-inl.h"
#include "slave/core/primitive/triangle/triangle_points-inl.h"
#include "slave/core/sampling/sequence-inl.h"
#include "slave/core/surface/detail-inl.h"
#include "slave/core/surface/noise-inl.h"
#include "slave/core/traverse/fan_groups-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

void camera_rays(const CameraView& camera, const PixelSample& sample, const PacketPixels& pixels,
                 FanPacket& rays, uint32_t* keys) {
  CameraKernel(camera, sample).run(pixels, rays, keys);
}

template <class Packet>
void points_of(const float* vertices, const Packet& rays, const PacketHits& hits,
               PacketPoints& points) {
  SurfaceKernel<Packet>(vertices, rays, hits).run(points);
}

void surface_detail(const DetailGroup& group, DetailPoints& points) {
  DetailKernel(group, points).run();
}

void emitter_samples(const LitSurfaces& surfaces, EmitterSamples& samples) {
  EmitterKernel(surfaces, samples).run();
}

void sky_light(const SkyView& sky, SkyPoints& points) { SkyKernel(sky, points).look_up(); }
void sky_samples(const SkyView& sky, SkyPoints& points) { SkyKernel(sky, points).sample(); }

void noise(NoisePoints& points) { NoiseLanes::run(points); }

void group_fans(FanTargets& targets) { FanGroups(targets).run(); }

void filter(FilterPlanes& planes, int radius, int x, int y, int width, int height) {
  DiscontinuityFilter(planes, radius).run(x, y, width, height);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <array>

#include "common/base/check.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/kernels/view_tables.h"
#include "slave/core/primitive/patch/patch_support.h"

namespace tessera::core {
namespace {

// All entry points of one instruction set.
#define TESSERA_KERNELS(set)                                                                   \
  set::camera_rays, set::points_of<FanPacket>, set::points_of<RayPacket>, set::surface_detail, \
      set::sky_light, set::sky_samples, set::sample_points, set::emitter_samples, set::noise,  \
      set::group_fans, set::bound_points, set::begin_gather, set::end_gather, set::filter

template <class... Entries>
KernelTable table_of(Isa isa, int lane_count, Entries... entries) {
  const auto bvh = bvh_kernels(isa);
  const auto kd = kd_kernels(isa);
  const auto instanced = instance_kernels(isa);
  const auto patched = kKnowsPatches ? patch_kernels(isa) : ViewTables<PatchedView>{};
  return {isa,     lane_count,    entries...,     bvh.by8,     bvh.by16,     kd.by8,
          kd.by16, instanced.by8, instanced.by16, patched.by8, patched.by16, bsdf_kernels(isa)};
}

const auto& tables() {
  static const std::array all {
    table_of(Isa::kScalar, 1, TESSERA_KERNELS(N_SCALAR)),
#if HWY_TARGETS & HWY_SSE4
        table_of(Isa::kSse4, 4, TESSERA_KERNELS(N_SSE4)),
#endif
#if HWY_TARGETS & HWY_AVX2
        table_of(Isa::kAvx2, 8, TESSERA_KERNELS(N_AVX2)),
#endif
#if HWY_TARGETS & HWY_AVX3
        table_of(Isa::kAvx512, 16, TESSERA_KERNELS(N_AVX3)),
#endif
  };
  return all;
}

}  // namespace

const KernelTable& kernels_for(Isa isa) {
  for (const KernelTable& table : tables()) {
    if (table.isa == isa) return table;
  }
  TESSERA_CHECK(false && "instruction set not compiled in");
  return tables()[0];
}

IsaMask compiled_isas() {
  IsaMask mask = 0;
  for (const KernelTable& table : tables()) mask |= isa_bit(table.isa);
  return mask;
}

}  // namespace tessera::core

#endif  // HWY_ONCE
