// SPDX-License-Identifier: Apache-2.0
// Uniform refinement for a bundle of rays, with one subdivision for all (thesis, 6.3.5), in
// float32.
//
// Threads. Pure functions.
#if defined(TESSERA_BENCH_LANE_REFINE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_BENCH_LANE_REFINE_INL_H_
#undef TESSERA_BENCH_LANE_REFINE_INL_H_
#else
#define TESSERA_BENCH_LANE_REFINE_INL_H_
#endif

#include "tests/bench/lane_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Uniform refinement of a patch for all rays of a bundle at once.
template <size_t kMost>
class LaneRefine {
  using T = FloatsOf<kMost>;
  using Rays = LaneRaysIn<kMost>;

 public:
  LaneRefine(const LaneScene& scene, const LaneHow& how, const LaneBundle&, Rays& rays)
      : scene_(scene), how_(how), rays_(rays) {}

  // Requires: parts are whole patches.
  HWY_INLINE void test(uint32_t number, MaskOf<T>) {
    const LanePatch& patch = scene_.patches[scene_.parts[number].patch];
    Node* const first = stack_;
    for (int a = 0; a < 3; ++a)
      for (int k = 0; k < 16; ++k) first->p[a][k] = patch.points[a][k];
    first->low[0] = first->low[1] = 0;
    first->depth = 0;
    int depth = 1;
    while (depth > 0) {
      Node& node = stack_[depth - 1];
      if (is_elsewhere(node)) {
        --depth;
      } else if (node.depth == how_.level) {
        facet(node, number);
        --depth;
      } else {
        Node& low = stack_[depth++];
        halve(node, low);
      }
    }
  }

 private:
  struct Node {
    alignas(64) float p[3][16];
    float low[2];
    int depth;
  };

  HWY_INLINE bool is_elsewhere(const Node& node) const {
    if constexpr (Rays::kCount == 1) {
      // One ray: on both sides of each of its planes.
      for (const auto& n : rays_.normal) {
        const float x = least_lane(n[0]), y = least_lane(n[1]), z = least_lane(n[2]);
        bool is_above = true, is_below = true;
        for (int k = 0; k < 16; ++k) {
          const float d = x * node.p[0][k] + y * node.p[1][k] + z * node.p[2][k];
          is_above &= d > 0;
          is_below &= d < 0;
        }
        if (is_above || is_below) return true;
      }
      return false;
    }
    for (const auto& n : rays_.corner) {
      float most = -__builtin_inff();
      for (int k = 0; k < 16; ++k) {
        const float d = n[0] * node.p[0][k] + n[1] * node.p[1][k] + n[2] * node.p[2][k];
        most = d > most ? d : most;
      }
      if (most < 0) return true;
    }
    return false;
  }

  // The upper half stays in `node`. Halves by u and by v in turns.
  static HWY_INLINE void halve(Node& node, Node& low) {
    const bool by_u = node.depth % 2 == 0;
    const int step = by_u ? 4 : 1, across = by_u ? 1 : 4;
    for (int a = 0; a < 3; ++a) {
      float* const p = node.p[a];
      float* const q = low.p[a];
      for (int k = 0; k < 4; ++k) {
        float* const x = p + across * k;
        float* const y = q + across * k;
        const float a0 = x[0], a1 = x[step], a2 = x[2 * step], a3 = x[3 * step];
        const float b0 = 0.5f * (a0 + a1), b1 = 0.5f * (a1 + a2), b2 = 0.5f * (a2 + a3);
        const float c0 = 0.5f * (b0 + b1), c1 = 0.5f * (b1 + b2), e = 0.5f * (c0 + c1);
        y[0] = a0;
        y[step] = b0;
        y[2 * step] = c0;
        y[3 * step] = e;
        x[0] = e;
        x[step] = c1;
        x[2 * step] = b2;
        x[3 * step] = a3;
      }
    }
    const int axis = by_u ? 0 : 1;
    ++node.depth;
    low.depth = node.depth;
    low.low[0] = node.low[0];
    low.low[1] = node.low[1];
    node.low[axis] += width(node.depth, axis);
  }
  static HWY_INLINE float width(int depth, int axis) {
    return 1.0f / static_cast<float>(1 << ((depth + 1 - axis) / 2));
  }

  HWY_INLINE void facet(const Node& node, uint32_t number) {
    constexpr int kCorner[4] = {0, 3, 12, 15};
    T p[4][2], t[4];
    for (int c = 0; c < 4; ++c) {
      T x[3];
      for (int a = 0; a < 3; ++a) x[a] = set<T>(node.p[a][kCorner[c]]);
      for (int k = 0; k < 2; ++k) p[c][k] = dot3(rays_.normal[k], x);
      t[c] = dot3(rays_.d, x) * rays_.per_square;
    }
    const auto found = [&](MaskOf<T> hit, T r, T s) {
      const T depth = (1 - r) * ((1 - s) * t[0] + s * t[1]) + r * ((1 - s) * t[2] + s * t[3]);
      rays_.take(hit, depth, r * width(node.depth, 0) + node.low[0],
                 s * width(node.depth, 1) + node.low[1], number);
    };
    if (how_.is_bilinear) {
      bilinear(p, found);
    } else {
      triangles(p, t, node, number);
    }
  }

  template <class Found>
  static HWY_INLINE void bilinear(const T (&p)[4][2], const Found& found) {
    T a[2], b[2], c[2];
    for (int k = 0; k < 2; ++k) {
      a[k] = p[2][k] - p[0][k];
      b[k] = p[1][k] - p[0][k];
      c[k] = p[3][k] - p[2][k] - b[k];
    }
    const auto cross = [](const T* x, const T* y) { return x[0] * y[1] - x[1] * y[0]; };
    const T q2 = cross(a, c), q1 = cross(p[0], c) + cross(a, b), q0 = cross(p[0], b);
    const T square = q1 * q1 - 4 * (q2 * q0);
    const T q = -0.5f * (q1 + copy_sign(sqrt(max(square, 0.0f)), q1));
    const T roots[2] = {q / q2, q0 / q};
    for (const T r : roots) {
      const T x = b[0] + r * c[0], y = b[1] + r * c[1];
      const T s = -((p[0][0] + r * a[0]) * x + (p[0][1] + r * a[1]) * y) / (x * x + y * y);
      found(square >= set<T>(0) && r >= set<T>(-kEdge) && r <= set<T>(1 + kEdge) &&
                s >= set<T>(-kEdge) && s <= set<T>(1 + kEdge),
            r, s);
    }
  }

  HWY_INLINE void triangles(const T (&p)[4][2], const T (&t)[4], const Node& node,
                            uint32_t number) {
    // (0, 0), (1, 0), (1, 1) and (0, 0), (1, 1), (0, 1); corner 2 r + s.
    constexpr int kOf[2][3] = {{0, 2, 3}, {0, 3, 1}};
    constexpr float kR[4] = {0, 0, 1, 1}, kS[4] = {0, 1, 0, 1};
    for (const auto& corner : kOf) {
      T side[3];
      for (int k = 0; k < 3; ++k) {
        const auto& from = p[corner[(k + 1) % 3]];
        const auto& to = p[corner[(k + 2) % 3]];
        side[k] = from[0] * to[1] - from[1] * to[0];
      }
      const T zero = set<T>(0), sum = side[0] + side[1] + side[2];
      const MaskOf<T> hit = (side[0] >= zero && side[1] >= zero && side[2] >= zero) ||
                            (side[0] <= zero && side[1] <= zero && side[2] <= zero);
      const T inverse = 1 / sum;
      T depth = zero, r = zero, s = zero;
      for (int k = 0; k < 3; ++k) {
        const T share = side[k] * inverse;
        depth = depth + share * t[corner[k]];
        r = r + share * kR[corner[k]];
        s = s + share * kS[corner[k]];
      }
      rays_.take(hit && sum != zero, depth, r * width(node.depth, 0) + node.low[0],
                 s * width(node.depth, 1) + node.low[1], number);
    }
  }

  static constexpr float kEdge = 0x1p-16f;  // beyond a facet, for float32

  const LaneScene& scene_;
  const LaneHow& how_;
  Rays& rays_;
  Node stack_[32];
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
