// SPDX-License-Identifier: Apache-2.0
// One ray and the boxes of a node, all at once.
//
// After Wald, Benthin, Boulos, "Getting rid of packets", 2008, and Ize, "Robust BVH ray traversal",
// JCGT 2(2), 2013.
//
// A ray meets the plane p of an axis at t = (p - o) / d, computed as p r + c with r = 1 / d and c =
// -o r, one fused operation. It is off by at most
//    1 u |p - o| |r|       r itself
//    2 u |o| |r|           product and sum of c, at most 1 u |c| each
//    1 u |p - o| |r|       the fused operation
// and what c was moved by; c is moved out by 8 u (|p| + |o|) |r| for the largest p of the scene,
// twice that bound, and by BoxRay::pad where the ray hardly moves along the axis. So t_in is never
// too large and t_out never too small.
//
// Threads. One traversal owns one.
#include <stddef.h>

#include "slave/core/accel/bvh_layout.h"
#include "slave/core/simd/counts_layout.h"

#if defined(TESSERA_CORE_RAY_SLABS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_RAY_SLABS_INL_H_
#undef TESSERA_CORE_RAY_SLABS_INL_H_
#else
#define TESSERA_CORE_RAY_SLABS_INL_H_
#endif

#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Offsets of the planes of a node through which a ray comes in and goes out, by axis, in floats.
struct SlabOrder {
  size_t in[3], out[3];
};

// By the bits of the axes along which a ray goes down.
template <int W>
struct SlabOrders {
  SlabOrder of[8];

  constexpr SlabOrders() : of() {
    static_assert(offsetof(BvhNode<W>, upper) == 3 * W * sizeof(float));
    for (uint32_t down = 0; down < 8; ++down) {
      for (size_t a = 0; a < 3; ++a) {
        of[down].in[a] = ((down >> a & 1u) * 3 + a) * W;
        of[down].out[a] = (2 * a + 3) * W - of[down].in[a];
      }
    }
  }
};
template <int W>
constexpr SlabOrders<W> kSlabOrders;

template <int W>
class RaySlabs {
  using V = FloatsOf<W>;  // children
  static constexpr size_t kStep = kLanesOf<V>;

 public:
  // Requires: the ray is set up for that box.
  HWY_INLINE void setup(const BoxRay& ray, const SceneBox& box) {
    setup_each<Axes<FloatsOf<4>>>([&](size_t) { return this; }, [&](size_t) { return &ray; },
                                  [&](size_t) { return &box; });
  }
  // Of as many rays as Axes holds.
  template <class Axes, class Slabs, class Ray, class Box>
  static HWY_INLINE void setup_each(const Slabs& to, const Ray& ray, const Box& box);
  // Returns: the bits of the children that the ray meets within its limits, with the t at which it
  // comes in.
  HWY_INLINE uint32_t overlapping(const BoxRay& ray, const BvhNode<W>& node, float* t_in) const;

 private:
  SlabOrder order_;
  alignas(16) float in_at_[4], out_at_[4];  // constants of t, by axis
};

// Computes c, moved out.
template <int W>
template <class Axes, class Slabs, class Ray, class Box>
void RaySlabs<W>::setup_each(const Slabs& to, const Ray& ray, const Box& box) {
  const auto from = Axes::load_each([&](size_t r) { return ray(r)->origin; });
  const auto inverse = Axes::load_each([&](size_t r) { return ray(r)->inverse; });
  const auto pad = Axes::load_each([&](size_t r) { return ray(r)->pad; });
  const auto farthest = Axes::load_each([&](size_t r) { return box(r)->farthest; });
  const auto error = (farthest + from.size()) * inverse.size() * Axes::all(8 * kRoundoff);
  const auto slack = error + pad;
  const auto at = -(from * inverse);
  (at - slack).store_each([&](size_t r) { return to(r)->in_at_; });
  (at + slack).store_each([&](size_t r) { return to(r)->out_at_; });
  for (size_t r = 0; r < Axes::kRays; ++r) to(r)->order_ = kSlabOrders<W>.of[ray(r)->down];
}

template <int W>
uint32_t RaySlabs<W>::overlapping(const BoxRay& ray, const BvhNode<W>& node, float* t_in) const {
  const float* const planes = reinterpret_cast<const float*>(&node);
  TESSERA_COUNT(nodes, 1);
  uint32_t bits = 0;
  for (size_t i = 0; i < W; i += kStep) {
    const auto plane_t = [&](size_t plane, size_t a, float at) {
      return mul_add(load<V>(planes + plane + i), set<V>(ray.inverse[a]), set<V>(at));
    };
    const auto enter = [&](size_t a) { return plane_t(order_.in[a], a, in_at_[a]); };
    const auto leave = [&](size_t a) { return plane_t(order_.out[a], a, out_at_[a]); };
    const V first = max(max(enter(0), enter(1)), max(enter(2), ray.near_limit));
    const V last = min(min(leave(0), leave(1)), min(leave(2), ray.far_limit));
    store(first, t_in + i);
    bits |= bits_of<V>(first <= last) << i;
  }
  TESSERA_COUNT(children, __builtin_popcount(bits));
  return bits;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
