// SPDX-License-Identifier: Apache-2.0
// What traversals of many rays at once share (bvh_flight-inl.h, bvh_stream-inl.h): lists of rays by
// number, and children of a node in the order of their distances, both without a branch on a ray;
// and how a group of rays is set up.
//
// Threads. One traversal owns one.
#include <stddef.h>
#include <stdint.h>

#if defined(TESSERA_CORE_MANY_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_MANY_RAYS_INL_H_
#undef TESSERA_CORE_MANY_RAYS_INL_H_
#else
#define TESSERA_CORE_MANY_RAYS_INL_H_
#endif

#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/traverse/node_stack-inl.h"
#include "slave/core/traverse/ray_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_AVX3

// Numbers of rays that are traced together, of which there are at most kMost.
template <int kMost>
struct SlotList {
  static_assert(kMost <= 256);

  uint8_t slot[kMost + 1];
  int count = 0;
  // Adds the slot or does not, without a branch. Requires: there is room either way.
  HWY_INLINE void add_if(bool is_wanted, uint8_t s) {
    slot[count] = s;
    count += is_wanted;
  }
};

// Entries of a stack as numbers that are in the order of their distances, which are not negative; a
// register has eight.
class ChildKeys {
 public:
  using Tag = hn::CappedTag<uint64_t, 8>;
  using Keys = hn::Vec<Tag>;
  using HalfTag = hn::Rebind<uint32_t, Tag>;
  using Halves = hn::Vec<HalfTag>;

  // distance: the bits of floats.
  static HWY_INLINE Keys of(Halves distance, Halves child) {
    return hn::Or(hn::ShiftLeft<32>(hn::PromoteTo(Tag(), distance)), hn::PromoteTo(Tag(), child));
  }
  // Batcher's odd-even merge sort of 4 and of 8 keys, the greatest first; zeros end up last.
  static HWY_INLINE Keys sorted4(Keys v) {
    v = exchanged<1, 0, 3, 2, 5, 4, 7, 6>(v);
    v = exchanged<2, 3, 0, 1, 6, 7, 4, 5>(v);
    return exchanged<0, 2, 1, 3, 4, 6, 5, 7>(v);
  }
  static HWY_INLINE Keys sorted8(Keys v) {
    v = sorted4(v);
    v = exchanged<4, 5, 6, 7, 0, 1, 2, 3>(v);
    v = exchanged<0, 1, 4, 5, 2, 3, 6, 7>(v);
    return exchanged<0, 2, 1, 4, 3, 6, 5, 7>(v);
  }

 private:
  // Lanes change places with their partners so that the greater key comes first.
  template <uint64_t... kPartner>
  static HWY_INLINE Keys exchanged(Keys v) {
    const hn::CappedTag<uint64_t, 8> keys;
    alignas(64) static constexpr uint64_t partner[8] = {kPartner...};
    const auto other = hn::TableLookupLanes(v, hn::IndicesFromVec(keys, hn::Load(keys, partner)));
    const auto is_later = hn::Lt(hn::Load(keys, partner), hn::Iota(keys, 0));
    return hn::IfThenElse(is_later, hn::Min(v, other), hn::Max(v, other));
  }
};
static_assert(sizeof(StackEntry) == 8 && offsetof(StackEntry, distance) == 4);

// Slots of rays that are set up together, as many as a register has room for. A slot has what was
// `given`, the `ray` and its `slabs`.
template <class View, class Slot>
class SlotGroup {
  using Group = Axes<FloatsOf<View::kWidth>>;

 public:
  static constexpr int kMost = static_cast<int>(Group::kRays);

  HWY_INLINE void add(Slot& slot) { slot_[count_++] = &slot; }
  HWY_INLINE int count() const { return count_; }
  HWY_INLINE Slot& operator[](int i) const { return *slot_[i]; }

  // Requires: the group is not empty. Returns: whether all rays are valid; else none is set up.
  HWY_INLINE bool set_up(const View& scene) {
    for (int i = count_; i < kMost; ++i) slot_[i] = slot_[count_ - 1];
    const auto ray = [&](size_t r) HWY_ATTR { return &slot_[r]->ray; };
    const auto given = [&](size_t r) HWY_ATTR { return &slot_[r]->given; };
    const auto slabs = [&](size_t r) HWY_ATTR { return &slot_[r]->slabs; };
    if (scene.nodes == nullptr || !OneRay::setup_each<Group>(ray, given, scene.box)) return false;
    RaySlabs<View::kWidth>::template setup_each<Group>(slabs, ray,
                                                       [&](size_t) HWY_ATTR { return &scene.box; });
    return true;
  }
  // Returns: whether the ray is valid.
  static HWY_NOINLINE bool set_up_alone(const View& scene, Slot& slot) {
    if (scene.nodes == nullptr || !slot.ray.setup(slot.given, scene.box)) return false;
    slot.slabs.setup(slot.ray, scene.box);
    return true;
  }

 private:
  Slot* slot_[kMost];
  int count_ = 0;
};

#endif  // HWY_TARGET == HWY_AVX3

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
