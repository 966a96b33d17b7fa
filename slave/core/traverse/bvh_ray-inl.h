// SPDX-License-Identifier: Apache-2.0
// Traversal of a wide hierarchy by one ray: all children of a node at once, closest and any hit.
// For rays that have no company: bounces, and packets that are none.
//
// After Wald, Benthin, Boulos, "Getting rid of packets", 2008, and Ize, "Robust BVH ray traversal",
// JCGT 2(2), 2013.
//
// Boxes. A ray meets the plane p of an axis at t = (p - o) / d, computed as p r + c with r = 1 / d
// and c = -o r, one fused operation. It is off by at most
//    1 u |p - o| |r|       r itself
//    2 u |o| |r|           product and sum of c, at most 1 u |c| each
//    1 u |p - o| |r|       the fused operation
// and what c was moved by; c is moved out by 8 u (|p| + |o|) |r| for the largest p of the scene,
// twice that bound, and by what setup_axis() asks for where the ray hardly moves along the axis. So
// t_in is never too large and t_out never too small.
//
// Threads. One traversal owns one.
#include <stddef.h>

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

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// By axis: where a node has the planes through which a ray comes in and goes out, from its first
// number on.
template <int W>
struct SlabOrder {
  size_t in[3], out[3];

  void set(uint32_t down) {
    static_assert(offsetof(BvhNode<W>, upper) == 3 * W * sizeof(float));
    for (size_t a = 0; a < 3; ++a) {
      in[a] = ((down >> a & 1u) * 3 + a) * W;
      out[a] = (2 * a + 3) * W - in[a];
    }
  }
};

template <class View, class Leaf>
class BvhRayTracer {
 public:
  explicit BvhRayTracer(const View& scene) : scene_(scene), leaf_(ray_) {}

  // Returns: whether there is a hit. blocker: of any hits, a block to look at first, or kNoBlock;
  // becomes the one where the hit is.
  bool run(const SingleRay& ray, uint32_t& blocker);
  bool run(const SingleRay& ray) {
    uint32_t none = kNoBlock;
    return run(ray, none);
  }

  const OneRay& ray() const { return ray_; }

 private:
  static constexpr int W = View::kWidth;
  static constexpr bool kAny = Leaf::kIsAny;
  using B = hn::CappedTag<float, W>;  // children
  using V = hn::Vec<B>;
  static constexpr size_t kStep = hn::MaxLanes(B());

  HWY_INLINE void setup_slabs();
  HWY_INLINE uint32_t overlapping(const BvhNode<W>& node, float* t_in) const;

  const View& scene_;
  OneRay ray_;
  Leaf leaf_;
  SlabOrder<W> order_;
  alignas(16) float in_at_[4], out_at_[4];  // constants of t, by axis
};

// c, moved out.
template <class View, class Leaf>
void BvhRayTracer<View, Leaf>::setup_slabs() {
  constexpr size_t kAxisStep = OneRay::kAxisStep;
  const OneRay::A d;
  for (size_t a = 0; a < 4; a += kAxisStep) {
    const auto from = hn::Load(d, ray_.origin + a), inverse = hn::Load(d, ray_.inverse + a);
    const auto reach = hn::Add(hn::Load(d, scene_.box.farthest + a), hn::Abs(from));
    const auto error = hn::Mul(hn::Mul(reach, hn::Abs(inverse)), hn::Set(d, 8 * kRoundoff));
    const auto slack = hn::Add(error, hn::Load(d, ray_.pad + a));
    const auto at = hn::Neg(hn::Mul(from, inverse));
    hn::Store(hn::Sub(at, slack), d, in_at_ + a);
    hn::Store(hn::Add(at, slack), d, out_at_ + a);
  }
  order_.set(ray_.down);
}

template <class View, class Leaf>
uint32_t BvhRayTracer<View, Leaf>::overlapping(const BvhNode<W>& node, float* t_in) const {
  const B b;
  const float* const planes = reinterpret_cast<const float*>(&node);
  TESSERA_COUNT(nodes, 1);
  uint32_t bits = 0;
  for (size_t i = 0; i < W; i += kStep) {
    const auto plane_t = [&](size_t plane, size_t a, float at) {
      return hn::MulAdd(hn::Load(b, planes + plane + i), hn::Set(b, ray_.inverse[a]),
                        hn::Set(b, at));
    };
    const auto enter = [&](size_t a) { return plane_t(order_.in[a], a, in_at_[a]); };
    const auto leave = [&](size_t a) { return plane_t(order_.out[a], a, out_at_[a]); };
    const V first =
        hn::Max(hn::Max(enter(0), enter(1)), hn::Max(enter(2), hn::Set(b, ray_.near_limit)));
    const V last =
        hn::Min(hn::Min(leave(0), leave(1)), hn::Min(leave(2), hn::Set(b, ray_.far_limit)));
    hn::Store(first, b, t_in + i);
    bits |= bits_of(b, hn::Le(first, last)) << i;
  }
  TESSERA_COUNT(children, __builtin_popcount(bits));
  return bits;
}

template <class View, class Leaf>
bool BvhRayTracer<View, Leaf>::run(const SingleRay& ray, uint32_t& blocker) {
  if (!ray_.setup(ray, scene_.box)) return false;
  leaf_.prepare();
  TESSERA_COUNT(singles, 1);
  if (kAny && blocker != kNoBlock && leaf_.test(scene_.shapes, blocker, 1) != kNoBlock) return true;
  setup_slabs();
  alignas(64) float t_in[W];
  NodeStack<View> stack(scene_);
  uint32_t child = stack.next(ray_.far_limit);
  while (child != kBvhNoChild) {
    if ((child & kBvhLeaf) == 0) {
      const BvhNode<W>& node = scene_.nodes[child];
      const uint32_t met = overlapping(node, t_in);
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
