// SPDX-License-Identifier: Apache-2.0
// Traversal of a wide hierarchy by many rays that have nothing in common, in turns: a ray goes on
// until its leaf has put a question off, and then another one does, so that questions of several
// rays are settled at once. For leaves whose questions take far longer than boxes, and instruction
// sets for which a flight (bvh_flight-inl.h) is not worth it. Decision: ../decisions/flights.md.
//
// A ray's answer is that of bvh_ray-inl.h: both visit the same boxes in the same order, for a ray
// knows the answers to all its questions when it goes on.
//
// Threads. One traversal owns one.
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_BVH_TURNS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BVH_TURNS_INL_H_
#undef TESSERA_CORE_BVH_TURNS_INL_H_
#else
#define TESSERA_CORE_BVH_TURNS_INL_H_
#endif

#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/traverse/bvh_flight-inl.h"
#include "slave/core/traverse/node_stack-inl.h"
#include "slave/core/traverse/ray_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Whether rays take turns in a structure. That takes leaves that put questions off (as BvhFlight
// has them), and registers that have room for a whole block.
template <class View, class Leaf>
constexpr bool kTakesTurns = false;
template <int W, class Shapes, class Leaf>
requires requires { typename Leaf::Settling; }
constexpr bool kTakesTurns<BvhView<W, Shapes>, Leaf> =
    !kFlies<BvhView<W, Shapes>, Leaf> && !Leaf::kSettlesAtOnce && kLanesOf<FloatsOf<W>> == W;

template <class View, class Leaf>
class BvhTurns {
  static constexpr int W = View::kWidth;
  static constexpr bool kAny = Leaf::kIsAny;
  static constexpr int kSlots = 16;
  using Settling = typename Leaf::Settling;

 public:
  // Requires: the scene outlives it. Some 60 KB, most of which is not touched.
  explicit BvhTurns(const View& scene) : scene_(scene) {}

  // Rays: as in BvhFlight, but for alone().
  template <class Rays>
  void run(Rays& rays);

 private:
  // A place for one ray after the other.
  struct Slot {
    OneRay ray;
    RaySlabs<W> slabs;
    Leaf leaf{ray};
    NodeStack<View> stack;
    int number = -1;  // of its ray; -1: there are no more
  };

  template <class Rays>
  HWY_INLINE void fill(Slot& slot, Rays& rays);
  HWY_INLINE bool visit_all(Slot& slot, Settling& settling);

  const View& scene_;
  Slot slots_[kSlots];
};

template <class View, class Leaf>
template <class Rays>
void BvhTurns<View, Leaf>::fill(Slot& slot, Rays& rays) {
  SingleRay given;
  while ((slot.number = rays.next(given)) >= 0) {
    if (scene_.nodes != nullptr && slot.ray.setup(given, scene_.box)) {
      slot.leaf.prepare();
      slot.slabs.setup(slot.ray, scene_.box);
      slot.stack.begin(scene_);
      TESSERA_COUNT(singles, 1);
      return;
    }
    rays.ended(slot.number, SingleHit{0, kNoPrimitive});
  }
}

// Returns: whether the ray has its answer; else it waits for one of its leaf.
template <class View, class Leaf>
bool BvhTurns<View, Leaf>::visit_all(Slot& slot, Settling& settling) {
  if (kAny && slot.ray.has_hit()) return true;
  alignas(64) float t_in[W];
  uint32_t child = slot.stack.next(slot.ray.far_limit);
  while (child != kBvhNoChild) {
    if ((child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = scene_.nodes[child];
      const uint32_t met = slot.slabs.overlapping(slot.ray, node, t_in);
      child = kAny ? slot.stack.descend_unsorted(node, met) : slot.stack.descend(node, met, t_in);
      if (child != kBvhNoChild) continue;
    } else {
      const uint32_t block = leaf_first(child);
      if (leaf_count(child) > 1) slot.stack.put_back(child + 1 - (1u << kBvhCountShift));
      const typename Leaf::Found found = slot.leaf.look(scene_.shapes, block);
      if (Leaf::may_hit(found)) {
        settling.settle(slot.leaf, block, found);
        if (!settling.is_settled(slot.leaf)) return false;
        if (kAny && slot.ray.has_hit()) return true;
      }
    }
    child = slot.stack.next(slot.ray.far_limit);
  }
  return true;
}

template <class View, class Leaf>
template <class Rays>
void BvhTurns<View, Leaf>::run(Rays& rays) {
  Settling settling(scene_.shapes);
  for (Slot& slot : slots_) fill(slot, rays);
  for (bool has_rays = true; has_rays;) {
    has_rays = false;
    bool has_moved = false;
    for (Slot& slot : slots_) {
      while (slot.number >= 0 && settling.is_settled(slot.leaf)) {
        has_moved = true;
        if (!visit_all(slot, settling)) break;
        const OneRay& ray = slot.ray;
        rays.ended(slot.number, SingleHit{ray.has_hit() ? ray.best_t : 0,
                                          static_cast<uint32_t>(ray.best)});  // -1: kNoPrimitive
        fill(slot, rays);
      }
      has_rays |= slot.number >= 0;
    }
    if (has_rays && !has_moved) settling.finish();
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
