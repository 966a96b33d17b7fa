// All kernels, compiled once per instruction set by Highway and reached through KernelTable.
// Nothing but hwy/, -inl.h, _layout.h and C headers may be included before the table. The project
// is built with -ffp-contract=off and what is reported uses no fused multiply-add, so every set
// computes the same bits.
//
// Targets: SSSE3 and the Ice Lake variant of AVX-512 have no name in Isa. The fallback is to be
// HWY_SCALAR with every compiler, one lane, and not Highway's emulation of 128 bits.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#define HWY_BROKEN_EMU128 1

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernel/kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernel/bundle_block-inl.h"
#include "slave/core/kernel/fan_block-inl.h"
#include "slave/core/kernel/fan_groups-inl.h"
#include "slave/core/kernel/packet-inl.h"
#include "slave/core/kernel/ray-inl.h"
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

template <int W>
void closest_ray(const BvhView<W>& scene, const SingleRay& ray, SingleHit& hit) {
  RayTracer<W, false> tracer(scene);
  const bool is_hit = tracer.run(ray);
  hit = {is_hit ? tracer.t() : 0, static_cast<uint32_t>(tracer.primitive())};
}

template <int W>
bool occluded_ray(const BvhView<W>& scene, const SingleRay& ray) {
  return RayTracer<W, true>(scene).run(ray);
}

void group_fans(FanTargets& targets) { FanGroups(targets).run(); }

HWY_INLINE SingleRay ray_of(const FanPacket& rays, size_t i) {
  return {{rays.origin[0], rays.origin[1], rays.origin[2]},
          {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
          rays.t_min,
          rays.t_max[i]};
}

HWY_INLINE SingleRay ray_of(const RayPacket& rays, size_t i) {
  return {{rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]},
          {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
          rays.t_min[i],
          rays.t_max[i]};
}

template <int W, class Rays, class Block, class Packet>
HWY_INLINE void closest(const BvhView<W>& scene, const Packet& rays, PacketHits& hits) {
  PacketTracer<W, Rays, Block> tracer(scene);
  if (tracer.run(rays)) return tracer.rays().store(hits);
  for (size_t i = 0; i < kPacketRays; ++i) {
    SingleHit hit{0, kNoPrimitive};
    if (rays.active >> i & 1u) closest_ray<W>(scene, ray_of(rays, i), hit);
    hits.t[i] = hit.t;
    hits.primitive[i] = hit.primitive;
  }
}

template <int W, class Rays, class Block, class Packet>
HWY_INLINE uint64_t occluded(const BvhView<W>& scene, const Packet& rays) {
  PacketTracer<W, Rays, Block> tracer(scene);
  if (tracer.run(rays)) return tracer.rays().blocked();
  uint64_t blocked = 0;
  for (uint64_t bits = rays.active; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<size_t>(__builtin_ctzll(bits));
    blocked |= uint64_t{occluded_ray<W>(scene, ray_of(rays, i))} << i;
  }
  return blocked;
}

template <int W>
void closest_fan(const BvhView<W>& scene, const FanPacket& rays, PacketHits& hits) {
  closest<W, FanRays, FanBlock<W, false>>(scene, rays, hits);
}
template <int W>
uint64_t occluded_fan(const BvhView<W>& scene, const FanPacket& rays) {
  return occluded<W, FanRays, FanBlock<W, true>>(scene, rays);
}
template <int W>
void closest_packet(const BvhView<W>& scene, const RayPacket& rays, PacketHits& hits) {
  closest<W, BundleRays, BundleBlock<W, false>>(scene, rays, hits);
}
template <int W>
uint64_t occluded_packet(const BvhView<W>& scene, const RayPacket& rays) {
  return occluded<W, BundleRays, BundleBlock<W, true>>(scene, rays);
}

template <int W>
constexpr BvhKernels<W> kBvhKernels{closest_ray<W>,  occluded_ray<W>,   closest_fan<W>,
                                    occluded_fan<W>, closest_packet<W>, occluded_packet<W>};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "common/base/check.h"
#include "slave/core/kernel/kernel_table.h"

namespace tessera::core {
namespace {

constexpr KernelTable kTables[] = {
    {Isa::kScalar, 1, N_SCALAR::trace_closest, N_SCALAR::trace_occluded, N_SCALAR::group_fans,
     N_SCALAR::kBvhKernels<8>, N_SCALAR::kBvhKernels<16>},
#if HWY_TARGETS & HWY_SSE4
    {Isa::kSse4, 4, N_SSE4::trace_closest, N_SSE4::trace_occluded, N_SSE4::group_fans,
     N_SSE4::kBvhKernels<8>, N_SSE4::kBvhKernels<16>},
#endif
#if HWY_TARGETS & HWY_AVX2
    {Isa::kAvx2, 8, N_AVX2::trace_closest, N_AVX2::trace_occluded, N_AVX2::group_fans,
     N_AVX2::kBvhKernels<8>, N_AVX2::kBvhKernels<16>},
#endif
#if HWY_TARGETS & HWY_AVX3
    {Isa::kAvx512, 16, N_AVX3::trace_closest, N_AVX3::trace_occluded, N_AVX3::group_fans,
     N_AVX3::kBvhKernels<8>, N_AVX3::kBvhKernels<16>},
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
