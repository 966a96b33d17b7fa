// SPDX-License-Identifier: Apache-2.0
// The rays of a bundle in one register, and their way through a plain binary hierarchy.
//
// Threads. Pure functions.
#if defined(TESSERA_BENCH_LANE_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_BENCH_LANE_RAYS_INL_H_
#undef TESSERA_BENCH_LANE_RAYS_INL_H_
#else
#define TESSERA_BENCH_LANE_RAYS_INL_H_
#endif

#include "slave/core/simd/real-inl.h"
#include "tests/bench/method_lanes_layout.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

using bench::LaneBundle;
using bench::LaneHow;
using bench::LaneKernels;
using bench::LaneNode;
using bench::LanePart;
using bench::LanePatch;
using bench::LaneScene;

// Sides of a part are widened by this much of their widths, for float32.
inline constexpr float kLaneOverlap = 0x1p-11f;

// The rays of a bundle, each with two planes that meet in it.
template <size_t kMost>
struct LaneRaysIn {
  using T = FloatsOf<kMost>;
  static constexpr size_t kCount = kLanesOf<T>;
  // Corners of 1, 2 x 2, 4 x 2 and 4 x 4 pixels in Morton order, one after the other around.
  static constexpr size_t kSquares[4][4] = {
      {0, 0, 0, 0}, {0, 1, 3, 2}, {0, 5, 7, 2}, {0, 5, 15, 10}};

  T d[3], inverse[3], normal[2][3], per_square, best, u, v;
  float corner[4][3];  // planes around all rays; a point outside of one is below 0
  float part[kCount];

  HWY_INLINE explicit LaneRaysIn(const LaneBundle& rays) {
    T square = set<T>(0);
    for (int a = 0; a < 3; ++a) {
      d[a] = load<T>(rays.direction[a]);
      inverse[a] = 1 / d[a];
      square = square + d[a] * d[a];
    }
    per_square = 1 / square;
    best = set<T>(__builtin_inff());
    u = v = set<T>(0);
    // A normal across the longest axis of the first ray, which is not near 0 for a bundle.
    int z = 0;
    for (int a = 1; a < 3; ++a)
      if (__builtin_fabsf(rays.direction[a][0]) > __builtin_fabsf(rays.direction[z][0])) z = a;
    const int x = (z + 1) % 3, y = (z + 2) % 3;
    normal[0][x] = d[z];
    normal[0][y] = set<T>(0);
    normal[0][z] = -d[x];
    normal[1][x] = set<T>(0);
    normal[1][y] = d[z];
    normal[1][z] = -d[y];
    for (auto& n : normal) {
      const T size = 1 / sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      for (T& component : n) component = component * size;
    }
    set_corners(rays);
    for (float& p : part) p = -1;
  }

  // Planes of the corner rays: those of a square of pixels in Morton order, or of the one ray.
  HWY_INLINE void set_corners(const LaneBundle& rays) {
    for (int k = 0; k < 4; ++k) {
      const size_t* const square = kSquares[kCount >= 16  ? 3
                                            : kCount >= 8 ? 2
                                            : kCount >= 4 ? 1
                                                          : 0];
      const size_t a = square[k], b = square[(k + 1) % 4], inside = square[(k + 2) % 4];
      float n[3], sum = 0;
      for (int c = 0; c < 3; ++c) {
        const int e = (c + 1) % 3, f = (c + 2) % 3;
        n[c] = rays.direction[e][a] * rays.direction[f][b] -
               rays.direction[f][a] * rays.direction[e][b];
      }
      for (int c = 0; c < 3; ++c) sum += n[c] * rays.direction[c][inside];
      for (int c = 0; c < 3; ++c) corner[k][c] = sum < 0 ? -n[c] : n[c];
    }
  }

  // The rays that pass a box before their best hit; least: where the first of them enters.
  HWY_INLINE MaskOf<T> passing(const LaneNode& node, T& enter) const {
    T near = set<T>(0), far = best;
    for (int a = 0; a < 3; ++a) {
      const T low = set<T>(node.low[a]) * inverse[a], high = set<T>(node.high[a]) * inverse[a];
      near = max(near, min(low, high));
      far = min(far, max(low, high));
    }
    enter = near;
    return near <= far * (1 + 0x1p-20f);
  }

  HWY_INLINE void take(MaskOf<T> hit, T t, T at_u, T at_v, uint32_t number) {
    const MaskOf<T> is_new = hit && t > set<T>(0) && t < best;
    best = select(is_new, t, best);
    u = select(is_new, at_u, u);
    v = select(is_new, at_v, v);
    const uint32_t bits = bits_of<T>(is_new);
    for (size_t i = 0; i < kCount; ++i)
      if ((bits >> i & 1) != 0) part[i] = static_cast<float>(number);
  }
  HWY_INLINE void write_to(LaneBundle& rays) const {
    store(best, rays.t);
    store(u, rays.u);
    store(v, rays.v);
    for (size_t i = 0; i < kCount; ++i) rays.part[i] = static_cast<uint32_t>(part[i]);
  }
};

template <size_t kMost, class Leaf>
HWY_INLINE void walk(const LaneScene& scene, LaneRaysIn<kMost>& rays, Leaf& leaf) {
  using T = FloatsOf<kMost>;
  uint32_t stack[64];
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const LaneNode& node = scene.nodes[stack[--depth]];
    T enter{};
    const MaskOf<T> passing = rays.passing(node, enter);
    if (is_none<T>(passing)) continue;
    if (node.is_leaf != 0) {
      leaf.test(node.child_or_part, passing);
      continue;
    }
    const uint32_t child = node.child_or_part;
    T first{}, second{};
    const MaskOf<T> low = rays.passing(scene.nodes[child], first);
    const MaskOf<T> high = rays.passing(scene.nodes[child + 1], second);
    const bool has_low = !is_none<T>(low), has_high = !is_none<T>(high);
    const T none = set<T>(__builtin_inff());
    const bool is_low_first =
        least_lane(select(low, first, none)) <= least_lane(select(high, second, none));
    if (has_high && is_low_first) stack[depth++] = child + 1;
    if (has_low) stack[depth++] = child;
    if (has_high && !is_low_first) stack[depth++] = child + 1;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
