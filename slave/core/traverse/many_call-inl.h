// SPDX-License-Identifier: Apache-2.0
// The calls for rays with origins of their own, as many as there are. A packet of them that forms a
// bundle is traced together where that pays. The rays of all other packets have nothing in common
// and fly together (bvh_flight-inl.h), stream (bvh_stream-inl.h), take turns (bvh_turns-inl.h) or
// go one by one, whatever the structure and the instruction set have.
//
// Threads. A call writes what it is given, and nothing else.
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_MANY_CALL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_MANY_CALL_INL_H_
#undef TESSERA_CORE_MANY_CALL_INL_H_
#else
#define TESSERA_CORE_MANY_CALL_INL_H_
#endif

#include "slave/core/traverse/packet_call-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

HWY_INLINE ManyRays packet_of(const ManyRays& rays, int p) {
  const size_t at = static_cast<size_t>(p) * kPacketRays;
  return {{rays.origin[0] + at, rays.origin[1] + at, rays.origin[2] + at},
          {rays.direction[0] + at, rays.direction[1] + at, rays.direction[2] + at},
          rays.t_min + at,
          rays.t_max + at,
          rays.active + p,
          1,
          rays.habit,
          rays.excluded == nullptr ? nullptr : rays.excluded + at};
}
HWY_INLINE HitArrays hits_of(const HitArrays& hits, int p) {
  const size_t at = static_cast<size_t>(p) * kPacketRays;
  return {hits.t + at, hits.primitive + at};
}

// The rays that are left of many when packets that form bundles are traced, one after the other,
// for a flight. `Call` traces a packet together where that pays, and says which of its rays are
// left:
//   uint64_t together(int p);
//   void ended(int i, const SingleHit& hit);
//   SingleHit alone(const SingleRay& ray);
template <class Call>
class RaysLeft {
 public:
  RaysLeft(const ManyRays& rays, Call& call) : rays_(rays), call_(call) {}

  // Goes on to the next packet with rays that are left. Returns: whether there is one.
  HWY_INLINE bool advance() {
    while (bits_ == 0) {
      if (++packet_ == rays_.packet_count) return false;
      bits_ = call_.together(packet_);
    }
    return true;
  }
  HWY_INLINE int next(SingleRay& ray) {
    if (HWY_UNLIKELY(bits_ == 0) && (packet_ == rays_.packet_count || !advance())) return -1;
    const int i = packet_ * kPacketRays + __builtin_ctzll(bits_);
    bits_ &= bits_ - 1;
    ray = ray_of(rays_, static_cast<size_t>(i));
    return i;
  }
  HWY_INLINE void ended(int i, const SingleHit& hit) { call_.ended(i, hit); }
  HWY_INLINE SingleHit alone(const SingleRay& ray) const { return call_.alone(ray); }

 private:
  const ManyRays& rays_;
  Call& call_;
  int packet_ = -1;
  uint64_t bits_ = 0;
};

template <class View>
struct ClosestCall : ClosestAnswers<View> {
  const ManyRays& rays;

  HWY_NOINLINE uint64_t together(int p) {
    const ManyRays packet = packet_of(rays, p);
    const HitArrays found = hits_of(this->hits, p);
    typename Tracers<View>::template Bundle<false> tracer(this->scene);
    if (run_together(tracer, packet) == Together::kDone) {
      tracer.write_to(found);
      return 0;
    }
    put_misses(found);
    return packet.active[0];
  }
};

template <class View>
void closest_many(const View& scene, const ManyRays& rays, const HitArrays& hits) {
  ClosestCall<View> call{{scene, hits}, rays};
  RaysLeft<ClosestCall<View>> left(rays, call);
  using Leaf = typename Tracers<View>::Leaves::template Ray<false>;
  if (left.advance()) trace_each<Leaf>(scene, left);
}

template <class View>
struct AnyCall {
  const View& scene;
  const ManyRays& rays;
  uint64_t* const blocked;

  // Rays that were found blocked before a packet was given up are blocked.
  HWY_NOINLINE uint64_t together(int p) {
    const ManyRays packet = packet_of(rays, p);
    typename Tracers<View>::template Bundle<true> tracer(scene);
    const Together how = run_together(tracer, packet);
    blocked[p] = how == Together::kNoFrustum ? 0 : tracer.blocked();
    return how == Together::kDone ? 0 : packet.active[0] & ~blocked[p];
  }
  HWY_INLINE void ended(int i, const SingleHit& hit) {
    blocked[i / kPacketRays] |= uint64_t{hit.primitive != kNoPrimitive} << i % kPacketRays;
  }
  HWY_INLINE SingleHit alone(const SingleRay& ray) const {
    return {0, occluded_ray(scene, ray) ? 0 : kNoPrimitive};
  }
};

// Where rays neither fly nor stream nor take turns they go one by one. What blocked one of them is
// tested first for the next, of whatever packet.
template <class View>
void occluded_many(const View& scene, const ManyRays& rays, uint64_t* blocked) {
  AnyCall<View> call{scene, rays, blocked};
  using Leaf = typename Tracers<View>::Leaves::template Ray<true>;
  if constexpr (kFlies<View, Leaf> || kStreams<View, Leaf> || kTakesTurns<View, Leaf>) {
    RaysLeft<AnyCall<View>> left(rays, call);
    if (left.advance()) trace_each<Leaf>(scene, left);
  } else {
    uint32_t blocker = kNoBlock;
    for (int p = 0; p < rays.packet_count; ++p) {
      const uint64_t left = call.together(p);
      blocked[p] |= occluded_alone(scene, packet_of(rays, p), left, blocker);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
