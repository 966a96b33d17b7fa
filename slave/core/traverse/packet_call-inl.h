// SPDX-License-Identifier: Apache-2.0
// The calls of the kernel table: rays traced together where that pays, else one by one.
//
// Threads. A call writes what it is given, and nothing else.
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_PACKET_CALL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PACKET_CALL_INL_H_
#undef TESSERA_CORE_PACKET_CALL_INL_H_
#else
#define TESSERA_CORE_PACKET_CALL_INL_H_
#endif

#include "slave/core/primitive/leaf-inl.h"
#include "slave/core/traverse/bvh_flight-inl.h"
#include "slave/core/traverse/bvh_packet-inl.h"
#include "slave/core/traverse/bvh_ray-inl.h"
#include "slave/core/traverse/bvh_stream-inl.h"
#include "slave/core/traverse/bvh_turns-inl.h"
#include "slave/core/traverse/kd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// The tracers of one ray, of a fan and of a bundle. `View` is the acceleration structure that is
// traversed.
template <class View>
struct Tracers;
template <int W, class Shapes>
struct Tracers<BvhView<W, Shapes>> {
  using View = BvhView<W, Shapes>;
  using Leaves = LeafTests<Shapes>;
  template <bool kAny>
  using Ray = BvhRayTracer<View, typename Leaves::template Ray<kAny>>;
  template <bool kAny>
  using Fan = PacketTracer<View, FanRays, typename Leaves::template Fan<kAny>>;
  template <bool kAny>
  using Bundle = PacketTracer<View, BundleRays, typename Leaves::template Bundle<kAny>>;
};
template <int W, class Shapes>
struct Tracers<KdView<W, Shapes>> {
  using View = KdView<W, Shapes>;
  using Leaves = LeafTests<Shapes>;
  template <bool kAny>
  using Ray = KdRayTracer<View, typename Leaves::template Ray<kAny>>;
  template <bool kAny>
  using Fan = KdPacketTracer<View, FanRays, typename Leaves::template Fan<kAny>>;
  template <bool kAny>
  using Bundle = KdPacketTracer<View, BundleRays, typename Leaves::template Bundle<kAny>>;
};

template <class View>
void closest_ray(const View& scene, const SingleRay& ray, SingleHit& hit) {
  typename Tracers<View>::template Ray<false> tracer(scene);
  hit = {0, kNoPrimitive};
  if (tracer.run(ray)) hit = {tracer.ray().best_t, static_cast<uint32_t>(tracer.ray().best)};
}

template <class View>
bool occluded_ray(const View& scene, const SingleRay& ray) {
  return typename Tracers<View>::template Ray<true>(scene).run(ray);
}

HWY_INLINE SingleRay ray_of(const Fan& rays, size_t i) {
  return {{rays.origin[0], rays.origin[1], rays.origin[2]},
          {rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]},
          rays.t_min,
          rays.t_max[i]};
}

HWY_INLINE SingleRay ray_of(const ShadowFan& fan, size_t i) {
  const ShadowFans& all = fan.fans;
  const auto number = static_cast<size_t>(all.targets->order[fan.first + i]);
  const auto& direction = all.targets->direction;
  const uint32_t at_end =
      all.excluded_at_end == nullptr ? kNoPrimitive : all.excluded_at_end[number];
  return {{all.origin[0], all.origin[1], all.origin[2]},
          {direction[0][number], direction[1][number], direction[2][number]},
          all.t_min,
          all.t_max,
          {at_end, all.excluded_at_origin}};
}

// The numbers are stored as one register where there is one of eight: what loads the origin or the
// direction as a register would have to wait for numbers that are stored one by one.
HWY_INLINE SingleRay ray_of(const ManyRays& rays, size_t i) {
  using Eight = float __attribute__((vector_size(32)));
  const auto& from = rays.origin;
  const auto& along = rays.direction;
  const Eight all = {from[0][i],  from[1][i],  from[2][i],    along[0][i],
                     along[1][i], along[2][i], rays.t_min[i], rays.t_max[i]};
  SingleRay ray;
  static_assert(offsetof(SingleRay, excluded) == sizeof all);
  __builtin_memcpy(static_cast<void*>(&ray), &all, sizeof all);
  if (rays.excluded != nullptr) ray.excluded[0] = rays.excluded[i];
  return ray;
}

HWY_INLINE PacketHabit& habit_of(const Fan& rays) { return *rays.habit; }
HWY_INLINE PacketHabit& habit_of(const ShadowFan& rays) { return rays.fans.habit; }
HWY_INLINE PacketHabit& habit_of(const ManyRays& rays) { return *rays.habit; }

// Returns: how it ended; kNoFrustum also where it was not tried.
template <class Tracer, class Packet>
HWY_INLINE Together run_together(Tracer& tracer, const Packet& rays) {
  PacketHabit& habit = habit_of(rays);
  if (habit.alone > 0) {
    --habit.alone;
    return Together::kNoFrustum;
  }
  constexpr int kWaitMax = 32;
  const Together how = tracer.run(rays);
  if (how == Together::kDone) habit.wait = 1;
  if (how != Together::kDoesNotPay) return how;
  habit.alone = habit.wait;
  habit.wait = habit.wait < kWaitMax ? 2 * habit.wait : kWaitMax;
  return how;
}

// What a flight for the closest hits asks of those whose rays fly.
template <class View>
struct ClosestAnswers {
  const View& scene;
  const HitArrays& hits;

  HWY_INLINE void ended(int i, const SingleHit& hit) {
    hits.t[i] = hit.t;
    hits.primitive[i] = hit.primitive;
  }
  HWY_INLINE SingleHit alone(const SingleRay& ray) const {
    SingleHit hit;
    closest_ray(scene, ray, hit);
    return hit;
  }
};

// The active rays of a packet, one after the other, for a flight.
template <class View, class Packet>
struct PacketInFlight : ClosestAnswers<View> {
  const Packet& packet;
  uint64_t left = packet.active;

  HWY_INLINE int next(SingleRay& ray) {
    if (left == 0) return -1;
    const int i = __builtin_ctzll(left);
    left &= left - 1;
    ray = ray_of(packet, static_cast<size_t>(i));
    return i;
  }
};

// Traces rays without company, as many as `rays` has.
template <class Leaf, class View, class Rays>
HWY_INLINE void trace_each(const View& scene, Rays& rays) {
  if constexpr (kFlies<View, Leaf>) {
    BvhFlight<View, Leaf>(scene).run(rays);
  } else if constexpr (kStreams<View, Leaf>) {
    BvhStream<View, Leaf>(scene).run(rays);
  } else if constexpr (kTakesTurns<View, Leaf>) {
    BvhTurns<View, Leaf>(scene).run(rays);
  } else {
    SingleRay ray;
    for (int i = rays.next(ray); i >= 0; i = rays.next(ray)) rays.ended(i, rays.alone(ray));
  }
}

HWY_INLINE void put_misses(const HitArrays& hits) {
  for (size_t i = 0; i < kPacketRays; ++i) {
    hits.t[i] = 0;
    hits.primitive[i] = kNoPrimitive;
  }
}

// Traces the rays of a packet without company.
template <class View, class Packet>
HWY_INLINE void closest_alone(const View& scene, const Packet& packet, const HitArrays& hits) {
  put_misses(hits);
  PacketInFlight<View, Packet> rays{{scene, hits}, packet};
  trace_each<typename Tracers<View>::Leaves::template Ray<false>>(scene, rays);
}

template <class Tracer, class View, class Packet>
HWY_INLINE void closest(const View& scene, const Packet& rays, const HitArrays& hits) {
  Tracer tracer(scene);
  if (run_together(tracer, rays) == Together::kDone) return tracer.write_to(hits);
  closest_alone(scene, rays, hits);
}

// Traces the rays of `bits` one by one. The block that blocked one ray is tested first for the
// next, since neighbours are mostly blocked by the same primitives. blocker: such a block, or
// kNoBlock; it becomes that of the last ray that is blocked.
template <class View, class Packet>
HWY_INLINE uint64_t occluded_alone(const View& scene, const Packet& rays, uint64_t bits,
                                   uint32_t& blocker) {
  uint64_t blocked = 0;
  for (; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<size_t>(__builtin_ctzll(bits));
    typename Tracers<View>::template Ray<true> tracer(scene);
    blocked |= uint64_t{tracer.run(ray_of(rays, i), blocker)} << i;
  }
  return blocked;
}

// Returns: bits of the rays that are blocked; by the tracer where that pays, else one by one.
template <class Tracer, class View, class Packet>
HWY_INLINE uint64_t occluded_by(Tracer& tracer, const View& scene, const Packet& rays) {
  const Together how = run_together(tracer, rays);
  if (how == Together::kDone) return tracer.blocked();
  // Rays that were found blocked before the packet was given up are blocked.
  uint64_t blocked = how == Together::kDoesNotPay ? tracer.blocked() : 0;
  uint32_t blocker = kNoBlock;
  return blocked | occluded_alone(scene, rays, rays.active & ~blocked, blocker);
}
template <class Tracer, class View, class Packet>
HWY_INLINE uint64_t occluded(const View& scene, const Packet& rays) {
  Tracer tracer(scene);
  return occluded_by(tracer, scene, rays);
}

// Fetches the rays that lie behind those of a fan, and the places of their hits. Where arrays do
// not follow one another as those of a FanPacket do, a caller has its rays in rows, and the next
// fan is there. What lies behind the end of a row may be fetched, too.
HWY_INLINE void fetch_next(const Fan& rays, const HitArrays& hits) {
  constexpr size_t kLine = 64 / sizeof(float);
  if (rays.direction[1] == rays.direction[0] + kPacketRays) return;
  for (size_t at = kPacketRays; at < 2 * kPacketRays; at += kLine) {
    for (const float* const direction : rays.direction) __builtin_prefetch(direction + at);
    __builtin_prefetch(rays.t_max + at);
    __builtin_prefetch(hits.t + at, 1);
    __builtin_prefetch(hits.primitive + at, 1);
  }
}

template <class View>
void closest_fan(const View& scene, const Fan& rays, const HitArrays& hits) {
  fetch_next(rays, hits);
  closest<typename Tracers<View>::template Fan<false>>(scene, rays, hits);
}
template <class View>
uint64_t occluded_fan(const View& scene, const Fan& rays) {
  return occluded<typename Tracers<View>::template Fan<true>>(scene, rays);
}
// Whether two shadow fans may be traced as one: in the hierarchy, where all rays of a fan are a few
// registers and leaves have a test for it.
template <class View>
constexpr bool kHasTwins = false;
template <int W, class Shapes>
constexpr bool kHasTwins<BvhView<W, Shapes>> = FanRays::kRows <= 4 && requires {
  typename LeafTests<Shapes>::Twins;
};

// Traces fans g and g + 1 as one. Returns: whether it did. is_light: whether the next may be, too.
template <class View>
HWY_NOINLINE bool occluded_twins(const View& scene, const ShadowFans& fans, int g,
                                 uint64_t* blocked, bool& is_light) {
  PacketTracer<View, TwinRays, typename Tracers<View>::Leaves::Twins> tracer(scene);
  const bool is_done = tracer.run(ShadowTwins(fans, g)) == Together::kDone;
  is_light = tracer.is_light();
  if (!is_done) return false;
  for (size_t f = 0; f < 2; ++f)
    blocked[static_cast<size_t>(g) + f] = tracer.rays().fan(f).blocked();
  return true;
}

template <class View>
void occluded_fans(const View& scene, const ShadowFans& fans, uint64_t* blocked) {
  const int count = fans.targets->group_count;
  bool is_light = false;  // whether the fan before had so little to do that two would have gained
  for (int g = 0; g < count; ++g) {
    if constexpr (kHasTwins<View>) {
      if (is_light && g + 1 < count && occluded_twins(scene, fans, g, blocked, is_light)) {
        ++g;
        continue;
      }
    }
    typename Tracers<View>::template Fan<true> tracer(scene);
    blocked[g] = occluded_by(tracer, scene, ShadowFan(fans, g));
    if constexpr (kHasTwins<View>) is_light = tracer.is_light();
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
