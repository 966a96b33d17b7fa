// SPDX-License-Identifier: Apache-2.0
// The frustum of 64 rays, four planes and two depths, and its test against W boxes at once.
//
// Everything is seen from one point, the origin, with z the main axis, positive where the rays go.
// A plane is x <= slope z + offset (or >=) with z >= 0: for rays from one point the offsets are 0.
//
// After Reshetov, Soupikov, Hurley, "Multi-level ray tracing algorithm", 2005. Rounding of the
// difference to the origin is monotonic, so boxes keep their order; slopes and offsets are moved
// out by what their products and sums with a depth may be off.
#include "slave/core/ray/packet_layout.h"
#include "slave/core/simd/counts_layout.h"

#if defined(TESSERA_CORE_FRUSTUM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_FRUSTUM_INL_H_
#undef TESSERA_CORE_FRUSTUM_INL_H_
#else
#define TESSERA_CORE_FRUSTUM_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

struct Frustum {
  float origin[3];
  int kx = 0, ky = 1, kz = 2;  // z: the main axis
  float side = 1;              // direction along it in which the rays go: 1 or -1
  float slope_u[2], slope_v[2];
  float offset_u[2] = {0, 0}, offset_v[2] = {0, 0};
  float z_far = 0;  // depth behind which no ray looks any more
  // No coordinate of the scene is farther from the origin. What is moved out for the roundings of
  // coordinates follows from it, and need not be found for each box and primitive.
  float reach = 0;

  HWY_INLINE void set_reach(const SceneBox& box) {
    reach = 0;
    for (int a = 0; a < 3; ++a) reach = max_of(reach, box.farthest[a] + abs_of(origin[a]));
  }

  void set_axis(int axis, bool is_negative) {
    kz = axis;
    kx = (axis + 1) % 3;
    ky = (axis + 2) % 3;
    side = is_negative ? -1.0f : 1.0f;
  }
};

// Bounds of u + v and of u - v of rays (u, v, 1) from one point: four planes more, across the
// diagonals. A piece of a surface that is seen askew fills little of its window. Bundles have none.
struct Diagonals {
  float sum[2], difference[2];
};
template <class Rays>
constexpr bool kHasDiagonals = requires(const Rays& rays) {
  rays.diagonals;
};

template <int W>
struct FrustumTests {
  using VB = FloatsOf<W>;  // children
  static constexpr size_t kStep = kLanesOf<VB>;

  // Children whose box meets the frustum, with the depth at which each begins.
  template <class Rays>
  static HWY_INLINE uint32_t boxes(const Rays& f, const BvhNode<W>& node, float* z_near) {
    const float* const z_in = f.side > 0 ? node.lower[f.kz] : node.upper[f.kz];
    const float* const z_out = f.side > 0 ? node.upper[f.kz] : node.lower[f.kz];
    const VB side = set<VB>(f.side);
    const VB ox = set<VB>(f.origin[f.kx]), oy = set<VB>(f.origin[f.ky]);
    const VB oz = set<VB>(f.origin[f.kz] * f.side);
    TESSERA_COUNT(nodes, 1);
    uint32_t bits = 0;
    for (size_t i = 0; i < W; i += kStep) {
      // One rounding, since `side` is 1 or -1.
      const VB in = mul_sub(load<VB>(z_in + i), side, oz),
               out = mul_sub(load<VB>(z_out + i), side, oz);
      const VB front = max(in, 0);
      const auto reach = [&](float slope, float offset, bool is_far) {
        return mul_add(set<VB>(slope), is_far ? out : front, set<VB>(offset));
      };
      auto keep = reach(f.slope_u[1], f.offset_u[1], f.slope_u[1] >= 0) >=
                  load<VB>(node.lower[f.kx] + i) - ox;
      keep = keep && reach(f.slope_u[0], f.offset_u[0], f.slope_u[0] < 0) <=
                         load<VB>(node.upper[f.kx] + i) - ox;
      keep = keep && reach(f.slope_v[1], f.offset_v[1], f.slope_v[1] >= 0) >=
                         load<VB>(node.lower[f.ky] + i) - oy;
      keep = keep && reach(f.slope_v[0], f.offset_v[0], f.slope_v[0] < 0) <=
                         load<VB>(node.upper[f.ky] + i) - oy;
      keep = keep && (out >= 0 && in <= f.z_far);
      if constexpr (kHasDiagonals<Rays>) {
        const auto from = [&](const float* plane, VB origin) {
          return load<VB>(plane + i) - origin;
        };
        keep = keep &&
               on_diagonals(f, from(node.lower[f.kx], ox), from(node.upper[f.kx], ox),
                            from(node.lower[f.ky], oy), from(node.upper[f.ky], oy), front, out);
      }
      store(in, z_near + i);
      bits |= bits_of<VB>(keep) << i;
    }
    TESSERA_COUNT(children, __builtin_popcount(bits));
    return bits;
  }

 private:
  // Whether boxes from `low` to `high`, of which the depths from `front` to `out` count, meet the
  // planes across the diagonals. Three roundings of coordinates and sums may add up: 4 u of both
  // coordinates hold them.
  template <class Rays>
  static HWY_INLINE MaskOf<VB> on_diagonals(const Rays& f, VB x_low, VB x_high, VB y_low, VB y_high,
                                            VB front, VB out) {
    const Diagonals& d = f.diagonals;
    const VB slack = set<VB>(f.reach * (8 * kRoundoff));
    const auto most = [&](float bound) {
      return mul_add(set<VB>(bound), bound >= 0 ? out : front, slack);
    };
    const auto least = [&](float bound) {
      return mul_sub(set<VB>(bound), bound < 0 ? out : front, slack);
    };
    return most(d.sum[1]) >= x_low + y_low && least(d.sum[0]) <= x_high + y_high &&
           most(d.difference[1]) >= x_low - y_high && least(d.difference[0]) <= x_high - y_low;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
