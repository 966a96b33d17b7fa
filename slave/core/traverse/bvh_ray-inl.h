// SPDX-License-Identifier: Apache-2.0
// Traversal of a wide hierarchy by one ray: all children of a node at once, closest and any hit.
// For rays that are traced alone: bounces, and packets that are neither fan nor bundle. Boxes:
// ray_slabs-inl.h.
//
// Threads. One traversal owns one.
#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

#if defined(TESSERA_CORE_BVH_RAY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BVH_RAY_INL_H_
#undef TESSERA_CORE_BVH_RAY_INL_H_
#else
#define TESSERA_CORE_BVH_RAY_INL_H_
#endif

#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/traverse/node_stack-inl.h"
#include "slave/core/traverse/ray_slabs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <class View, class Leaf>
class BvhRayTracer {
 public:
  explicit BvhRayTracer(const View& scene) : scene_(scene), leaf_(ray_) {}

  // Returns: whether there is a hit. blocker: for any hit, a block to test first, or kNoBlock;
  // becomes the block of the hit.
  bool run(const SingleRay& ray, uint32_t& blocker);
  bool run(const SingleRay& ray) {
    uint32_t none = kNoBlock;
    return run(ray, none);
  }

  const OneRay& ray() const { return ray_; }

 private:
  static constexpr int W = View::kWidth;
  static constexpr bool kAny = Leaf::kIsAny;

  const View& scene_;
  OneRay ray_;
  Leaf leaf_;
  RaySlabs<W> slabs_;
};

template <class View, class Leaf>
bool BvhRayTracer<View, Leaf>::run(const SingleRay& ray, uint32_t& blocker) {
  if (!ray_.setup(ray, scene_.box)) return false;
  leaf_.prepare();
  TESSERA_COUNT(singles, 1);
  if (kAny && blocker != kNoBlock && leaf_.test(scene_.shapes, blocker, 1) != kNoBlock) return true;
  slabs_.setup(ray_, scene_.box);
  alignas(64) float t_in[W];
  NodeStack<View> stack(scene_);
  uint32_t child = stack.next(ray_.far_limit);
  while (child != kBvhNoChild) {
    if ((child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = scene_.nodes[child];
      const uint32_t met = slabs_.overlapping(ray_, node, t_in);
      child = kAny ? stack.descend_unsorted(node, met) : stack.descend(node, met, t_in);
      if (child != kBvhNoChild) continue;
    } else {
      const uint32_t block = leaf_.test(scene_.shapes, leaf_first(child), leaf_count(child));
      if (kAny && block != kNoBlock) {
        blocker = block;
        return true;
      }
    }
    child = stack.next(ray_.far_limit);
  }
  return ray_.has_hit();
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
