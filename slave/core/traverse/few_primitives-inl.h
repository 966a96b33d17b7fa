// SPDX-License-Identifier: Apache-2.0
// Rays that have nothing in common, through a structure of a few primitives: each ray is tested
// against each primitive, a register of rays at a time, and there is no traversal. What a ray may
// hit first is found with bounds; only for that the answer itself is computed, so that it is that
// of bvh_ray-inl.h to the bit. Decision: ../decisions/few-primitives.md.
//
// Threads. One call owns one.
#include "slave/core/simd/counts_layout.h"
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_FEW_PRIMITIVES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_FEW_PRIMITIVES_INL_H_
#undef TESSERA_CORE_FEW_PRIMITIVES_INL_H_
#else
#define TESSERA_CORE_FEW_PRIMITIVES_INL_H_
#endif

#include "slave/core/primitive/list-inl.h"
#include "slave/core/traverse/many_call-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <class View, bool kAny>
class FewPrimitives {
  using V = Floats;
  using Lists = PrimitiveLists<typename View::Shapes>;
  using List = typename Lists::List;
  using Row = typename List::Row;
  static constexpr size_t kLanes = kLaneCount;

 public:
  // Takes all primitives of the structure. Returns: whether they are few and rays may be traced.
  bool find(const View& scene);
  // Traces the packet's rays. Returns: the bits of those that it leaves to others. Requires: find()
  // returned true.
  uint64_t run(const ManyRays& rays);
  // Answers of the rays that were traced.
  uint64_t blocked() const { return blocked_; }
  void write_to(const HitArrays& hits) const;

 private:
  // Returns: by ray, where t of the nearest hit begins at the latest.
  V look_at_all(const Row& row, size_t at);
  void pair_up(V far);
  void settle(const Row& row, const ManyRays& rays, size_t at);
  bool is_nearer(size_t ray, float t_min, float t, int32_t primitive) const {
    const bool is_lower = best_[ray] == -1 || primitive < best_[ray];
    return t >= t_min && (t < best_t_[ray] || (t == best_t_[ray] && is_lower));
  }

  List list_;
  uint64_t blocked_ = 0;
  alignas(64) float best_t_[kPacketRays];
  alignas(64) int32_t best_[kPacketRays];
  // Of the row at hand: by primitive, where t begins, and bits of the rays that are sure to pass
  // through.
  alignas(64) float low_[List::kMost][kLanes];
  uint32_t sure_[List::kMost];
  // Rays and what they may hit first.
  static constexpr size_t kPairs = List::kMost * kLanes + kLanes;
  size_t pair_count_ = 0;
  alignas(64) int32_t lane_[kPairs], item_[kPairs];
};

template <class View, bool kAny>
bool FewPrimitives<View, kAny>::find(const View& scene) {
  if (scene.nodes == nullptr) return false;
  list_.clear();
  const auto& child = scene.nodes[0].child;
  if (!is_all<Ints>(load<Ints>(reinterpret_cast<const int32_t*>(child)) < 0)) return false;
  for (const uint32_t leaf : child) {
    if (leaf == kBvhNoChild) continue;
    for (uint32_t i = 0; i < leaf_count(leaf); ++i) {
      if (!Lists::add(scene.shapes, leaf_first(leaf) + i, list_)) return false;
    }
  }
  return list_.count() > 0 && list_.finish(scene.box);
}

template <class View, bool kAny>
uint64_t FewPrimitives<View, kAny>::run(const ManyRays& rays) {
  uint64_t odd = 0;
  blocked_ = 0;
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    Row row;
    list_.set_row(rays, at, row);
    odd |= uint64_t{row.odd} << at;
    store(row.t_max, best_t_ + at);
    store(set<Ints>(-1), best_ + at);
    if (row.valid == row.odd) continue;
    pair_up(look_at_all(row, at));
    settle(row, rays, at);
  }
  return odd;
}

template <class View, bool kAny>
Floats FewPrimitives<View, kAny>::look_at_all(const Row& row, size_t at) {
  TESSERA_COUNT(singles, __builtin_popcount(row.valid));
  V far = row.t_max;
  uint32_t certain = 0;
  for (size_t k = 0; k < list_.count(); ++k) {
    const typename List::Sight sight = list_.look(row, k);
    store(sight.low, low_[k]);
    sure_[k] = bits_of<V>(sight.is_sure);
    certain |= bits_of<V>(sight.is_certain);
    if (!kAny) far = select(sight.is_certain, min(sight.high, far), far);
  }
  if (!kAny) return far;
  blocked_ |= uint64_t{certain} << at;
  return select(mask_of<V>(certain), set<V>(-__builtin_inff()), far);
}

// Lists what each ray may hit up to `far`. Where a primitive cannot be hit, `low_` is NaN.
template <class View, bool kAny>
void FewPrimitives<View, kAny>::pair_up(V far) {
  const Ints lane = counting_from<Ints>(0);
  pair_count_ = 0;
  for (size_t k = 0; k < list_.count(); ++k) {
    const auto is_open = load<V>(low_[k]) <= far;
    store_packed(lane, is_open, lane_ + pair_count_);
    store_unaligned(set<Ints>(static_cast<int32_t>(k)), item_ + pair_count_);
    pair_count_ += count_of<V>(is_open);
  }
  // Registers are loaded whole.
  store_unaligned(set<Ints>(0), lane_ + pair_count_);
  store_unaligned(set<Ints>(0), item_ + pair_count_);
}

template <class View, bool kAny>
void FewPrimitives<View, kAny>::settle(const Row& row, const ManyRays& rays, size_t at) {
  alignas(64) float t[kLanes];
  for (size_t first = 0; first < pair_count_; first += kLanes) {
    const uint32_t counts =
        list_.times(row, load<Ints>(lane_ + first), load<Ints>(item_ + first), t);
    const size_t count = min_of(kLanes, pair_count_ - first);
    TESSERA_COUNT(candidates, count);
    for (size_t i = 0; i < count; ++i) {
      const auto lane = static_cast<size_t>(lane_[first + i]);
      const auto item = static_cast<size_t>(item_[first + i]);
      const size_t ray = at + lane;
      const bool is_known = (counts >> i & 1u) != 0;
      const int32_t number = list_.number(item);
      if (is_known && !is_nearer(ray, rays.t_min[ray], t[i], number)) continue;
      if (HWY_UNLIKELY(!is_known || (sure_[item] >> lane & 1u) == 0)) {
        const float origin[3] = {rays.origin[0][ray], rays.origin[1][ray], rays.origin[2][ray]};
        const float direction[3] = {rays.direction[0][ray], rays.direction[1][ray],
                                    rays.direction[2][ray]};
        if (!list_.decide(item, origin, direction, is_known, t[i])) continue;
        if (!is_known && !is_nearer(ray, rays.t_min[ray], t[i], number)) continue;
      }
      best_t_[ray] = t[i];
      best_[ray] = number;
      blocked_ |= uint64_t{kAny} << ray;
    }
  }
}

template <class View, bool kAny>
void FewPrimitives<View, kAny>::write_to(const HitArrays& hits) const {
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const Ints best = load<Ints>(best_ + at);
    store(zero_unless(best != -1, load<V>(best_t_ + at)), hits.t + at);
    store(best, reinterpret_cast<int32_t*>(hits.primitive + at));
  }
}

// Fewer rays are not worth making the list.
constexpr int kFewRaysLeast = 8;

// Whether it is worth looking whether a structure has few primitives.
template <class View>
HWY_INLINE bool may_be_few(const View& scene, const ManyRays& rays) {
  if (scene.nodes == nullptr || (scene.nodes[0].child[0] & kBvhLeaf) == 0) return false;
  int count = 0;
  for (int p = 0; p < rays.packet_count && count < kFewRaysLeast; ++p)
    count += __builtin_popcountll(rays.active[p]);
  return count >= kFewRaysLeast;
}

// Returns: whether the rays were traced.
template <class View>
HWY_NOINLINE bool closest_of_few(const View& scene, const ManyRays& rays, const HitArrays& hits) {
  FewPrimitives<View, false> few;
  if (!few.find(scene)) return false;
  for (int p = 0; p < rays.packet_count; ++p) {
    const ManyRays packet = packet_of(rays, p);
    const HitArrays found = hits_of(hits, p);
    uint64_t odd = few.run(packet);
    few.write_to(found);
    for (; odd != 0; odd &= odd - 1) {
      const auto i = static_cast<size_t>(__builtin_ctzll(odd));
      SingleHit hit;
      closest_ray(scene, ray_of(packet, i), hit);
      found.t[i] = hit.t;
      found.primitive[i] = hit.primitive;
    }
  }
  return true;
}
template <class View>
HWY_NOINLINE bool occluded_by_few(const View& scene, const ManyRays& rays, uint64_t* blocked) {
  FewPrimitives<View, true> few;
  if (!few.find(scene)) return false;
  uint32_t blocker = kNoBlock;
  for (int p = 0; p < rays.packet_count; ++p) {
    const ManyRays packet = packet_of(rays, p);
    const uint64_t odd = few.run(packet);
    blocked[p] = few.blocked() | occluded_alone(scene, packet, odd, blocker);
  }
  return true;
}

// What closest_many() and occluded_many() do, where primitives may be few.
template <class View>
void closest_of_few_or_many(const View& scene, const ManyRays& rays, const HitArrays& hits) {
  if (!may_be_few(scene, rays) || !closest_of_few(scene, rays, hits))
    closest_many(scene, rays, hits);
}
template <class View>
void occluded_by_few_or_many(const View& scene, const ManyRays& rays, uint64_t* blocked) {
  if (!may_be_few(scene, rays) || !occluded_by_few(scene, rays, blocked))
    occluded_many(scene, rays, blocked);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
