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
#define HWY_TARGET_INCLUDE "slave/core/kernel/kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernel/bundle_block-inl.h"
#include "slave/core/kernel/entry-inl.h"
#include "slave/core/kernel/fan_block-inl.h"
#include "slave/core/kernel/fan_groups-inl.h"
#include "slave/core/kernel/kd-inl.h"
#include "slave/core/kernel/packet-inl.h"
#include "slave/core/kernel/ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

void group_fans(FanTargets& targets) { FanGroups(targets).run(); }

// What goes through a structure.
template <class View>
struct Tracers;
template <int W>
struct Tracers<BvhView<W>> {
  template <bool kAny>
  using Ray = BvhRayTracer<W, kAny>;
  template <bool kAny>
  using Fan = PacketTracer<W, FanRays, FanBlock<W, kAny>>;
  template <bool kAny>
  using Bundle = PacketTracer<W, BundleRays, BundleBlock<W, kAny>>;
};
template <int W>
struct Tracers<KdView<W>> {
  template <bool kAny>
  using Ray = KdRayTracer<W, kAny>;
  template <bool kAny>
  using Fan = KdPacketTracer<W, FanRays, FanBlock<W, kAny>>;
  template <bool kAny>
  using Bundle = KdPacketTracer<W, BundleRays, BundleBlock<W, kAny>>;
};

template <class View>
void closest_ray(const View& scene, const SingleRay& ray, SingleHit& hit) {
  typename Tracers<View>::template Ray<false> tracer(scene);
  hit = {0, kNoPrimitive};
  if (tracer.run(ray)) hit = {tracer.t(), static_cast<uint32_t>(tracer.primitive())};
}

template <class View>
bool occluded_ray(const View& scene, const SingleRay& ray) {
  return typename Tracers<View>::template Ray<true>(scene).run(ray);
}

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

// Returns: whether all of the rays have been traced together.
template <class Tracer, class Packet>
HWY_INLINE bool run_together(Tracer& tracer, const Packet& rays) {
  PacketHabit& habit = rays.habit;
  if (habit.alone > 0) {
    --habit.alone;
    return false;
  }
  constexpr int kWaitMax = 32;
  const Together how = tracer.run(rays);
  if (how == Together::kDone) habit.wait = 1;
  if (how != Together::kDoesNotPay) return how == Together::kDone;
  habit.alone = habit.wait;
  habit.wait = habit.wait < kWaitMax ? 2 * habit.wait : kWaitMax;
  return false;
}

template <class Tracer, class View, class Packet>
HWY_INLINE void closest(const View& scene, const Packet& rays, PacketHits& hits) {
  Tracer tracer(scene);
  if (run_together(tracer, rays)) return tracer.rays().store(hits);
  for (size_t i = 0; i < kPacketRays; ++i) {
    SingleHit hit{0, kNoPrimitive};
    if (rays.active >> i & 1u) closest_ray(scene, ray_of(rays, i), hit);
    hits.t[i] = hit.t;
    hits.primitive[i] = hit.primitive;
  }
}

template <class Tracer, class View, class Packet>
HWY_INLINE uint64_t occluded(const View& scene, const Packet& rays) {
  Tracer tracer(scene);
  if (run_together(tracer, rays)) return tracer.rays().blocked();
  uint64_t blocked = 0;
  for (uint64_t bits = rays.active; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<size_t>(__builtin_ctzll(bits));
    blocked |= uint64_t{occluded_ray(scene, ray_of(rays, i))} << i;
  }
  return blocked;
}

template <class View>
void enter_fans(const View& scene, const FanWindow& window, FanEntry& entry) {
  find_entry(scene, window, entry);
}
template <class View>
void closest_fan(const View& scene, const FanPacket& rays, PacketHits& hits) {
  closest<typename Tracers<View>::template Fan<false>>(scene, rays, hits);
}
template <class View>
uint64_t occluded_fan(const View& scene, const FanPacket& rays) {
  return occluded<typename Tracers<View>::template Fan<true>>(scene, rays);
}
template <class View>
void closest_packet(const View& scene, const RayPacket& rays, PacketHits& hits) {
  closest<typename Tracers<View>::template Bundle<false>>(scene, rays, hits);
}
template <class View>
uint64_t occluded_packet(const View& scene, const RayPacket& rays) {
  return occluded<typename Tracers<View>::template Bundle<true>>(scene, rays);
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
#include "slave/core/kernel/kernel_table.h"

namespace tessera::core {
namespace {

// All entry points of one instruction set.
#define TESSERA_KERNELS(set)                                              \
  set::group_fans, set::kKernels<BvhView<8>>, set::kKernels<BvhView<16>>, \
      set::kKernels<KdView<8>>, set::kKernels<KdView<16>>

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
