// SPDX-License-Identifier: Apache-2.0
// All kernels, compiled once per instruction set by Highway and reached through KernelTable.
// Nothing but hwy/, -inl.h, _layout.h and C headers may be included before the table. The project
// is built with -ffp-contract=off and what is reported uses no fused multiply-add, so every set
// computes the same bits.
//
// Targets: SSSE3 and the Ice Lake variant of AVX-512 have no name in Isa. The fallback is to be
// HWY_SCALAR with every compiler, one lane, and not Highway's emulation of 128 bits.
#ifdef TESSERA_FEW_INSTRUCTION_SETS  // sanitizers, for the time that it takes to compile
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3 | HWY_AVX3_DL)
#else
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#endif
#define HWY_BROKEN_EMU128 1

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/bsdf/glossy-inl.h"
#include "slave/core/bsdf/layered-inl.h"
#include "slave/core/camera/camera-inl.h"
#include "slave/core/light/emitter-inl.h"
#include "slave/core/light/irradiance_filter-inl.h"
#include "slave/core/light/sky-inl.h"
#include "slave/core/light/vpl_gather-inl.h"
#include "slave/core/primitive/triangle/triangle_points-inl.h"
#include "slave/core/sampling/sequence-inl.h"
#include "slave/core/surface/detail-inl.h"
#include "slave/core/surface/noise-inl.h"
#include "slave/core/traverse/entry-inl.h"
#include "slave/core/traverse/fan_groups-inl.h"
#include "slave/core/traverse/packet_call-inl.h"

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

template <class View>
void enter_fans(const View& scene, const FanWindow& window, FanEntry& entry) {
  find_entry(scene, window, entry);
}

template <class View>
constexpr ViewKernels<View> kKernels{closest_ray<View>,    occluded_ray<View>, enter_fans<View>,
                                     closest_fan<View>,    occluded_fan<View>, closest_packet<View>,
                                     occluded_packet<View>};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "common/base/check.h"
#include "slave/core/kernels/kernel_table.h"

namespace tessera::core {
namespace {

// All entry points of one instruction set.
#define TESSERA_KERNELS(set)                                                                       \
  set::camera_rays, set::points_of<FanPacket>, set::points_of<RayPacket>, set::surface_detail,     \
      set::sky_light, set::sky_samples, set::sample_points, set::emitter_samples,                  \
      set::sample_diffuse, set::sample_glossy, set::evaluate_glossy, set::sample_layered,          \
      set::evaluate_layered, set::noise, set::group_fans, set::bound_points, set::begin_gather,    \
      set::end_gather, set::filter, set::kKernels<TriangleBvh<8>>, set::kKernels<TriangleBvh<16>>, \
      set::kKernels<TriangleKd<8>>, set::kKernels<TriangleKd<16>>

constexpr KernelTable kTables[] = {
    {Isa::kScalar, 1, TESSERA_KERNELS(N_SCALAR)},
#if HWY_TARGETS & HWY_SSE4
    {Isa::kSse4, 4, TESSERA_KERNELS(N_SSE4)},
#endif
#if HWY_TARGETS & HWY_AVX2
    {Isa::kAvx2, 8, TESSERA_KERNELS(N_AVX2)},
#endif
#if HWY_TARGETS & HWY_AVX3
    {Isa::kAvx512, 16, TESSERA_KERNELS(N_AVX3)},
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
