// SPDX-License-Identifier: Apache-2.0
// The triangles of a block that a frustum may meet: those with a corner on the inner side of each
// of its planes.
//
// Threads. Pure functions.
#include "slave/core/primitive/triangle/triangle_layout.h"
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_TRIANGLE_FRUSTUM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_TRIANGLE_FRUSTUM_INL_H_
#undef TESSERA_CORE_TRIANGLE_FRUSTUM_INL_H_
#else
#define TESSERA_CORE_TRIANGLE_FRUSTUM_INL_H_
#endif

#include "slave/core/ray/frustum-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Corners of W triangles, seen from the origin of a frustum.
template <class VB>
struct Corners {
  VB x[3], y[3], z[3], z_low;
};

// Slopes of a fan's planes, each in all lanes, if kIsSpread. Where registers hold four triangles, a
// block takes several steps, and each would put the slopes there again.
template <class VB, bool kIsSpread>
struct PlanesOf {
  struct {
    VB sum[2], difference[2];
  } diagonals;
  VB slope_u[2], slope_v[2];

  template <class Rays>
  HWY_INLINE void spread(const Rays& f) {
    for (size_t k = 0; k < 2; ++k) {
      slope_u[k] = set<VB>(f.slope_u[k]);
      slope_v[k] = set<VB>(f.slope_v[k]);
      diagonals.sum[k] = set<VB>(f.diagonals.sum[k]);
      diagonals.difference[k] = set<VB>(f.diagonals.difference[k]);
    }
  }
};
template <class VB>
struct PlanesOf<VB, false> {
  template <class Rays>
  HWY_INLINE void spread(const Rays&) {}
};

template <int W>
struct FrustumTriangles {
  using VB = FloatsOf<W>;  // triangles
  using MB = MaskOf<VB>;

  static VB largest(VB p, VB q, VB r) { return max(max(p, q), r); }

  static HWY_INLINE Corners<VB> corners(const Frustum& f, const TriangleBlock<W>& block,
                                        size_t first) {
    Corners<VB> p;
    const VB side = set<VB>(f.side), z_origin = set<VB>(f.origin[f.kz] * f.side);
    for (int c = 0; c < 3; ++c) {
      const auto at = [&](int axis) { return load<VB>(block.vertex[3 * c + axis] + first); };
      p.x[c] = at(f.kx) - f.origin[f.kx];
      p.y[c] = at(f.ky) - f.origin[f.ky];
      p.z[c] = mul_sub(at(f.kz), side, z_origin);  // one rounding, since `side` is 1 or -1
    }
    p.z_low = min(min(p.z[0], p.z[1]), p.z[2]);
    return p;
  }

  // The largest coordinate of each.
  static HWY_INLINE VB sizes(const Corners<VB>& p) {
    const auto size = [&](int c) { return largest(abs(p.x[c]), abs(p.y[c]), abs(p.z[c])); };
    return largest(size(0), size(1), size(2));
  }

  // Triangles with a corner on the inner side of each plane. A lane without triangle is NaN and
  // fails the first comparison. planes: those of f, or f itself.
  template <class Rays, class Planes>
  static HWY_INLINE MB triangles(const Rays& f, const Planes& planes, const Corners<VB>& p) {
    const MB in_front = largest(p.z[0], p.z[1], p.z[2]) >= 0;
    // 4 u s for the roundings of a corner and of its product; s: the reach.
    const float slack = f.reach * (4 * kRoundoff);
    const auto inside = [&](float offset) {  // planes of rays from one point have none
      return set<VB>(kHasDiagonals<Rays> ? -slack : offset - slack);
    };
    const auto meets = [&](const VB* q, const auto* slope, const float* offset) {
      const VB low = in_lanes(slope[0]), high = in_lanes(slope[1]);
      const auto below = [&](int c) { return mul_sub(high, p.z[c], q[c]); };
      const auto above = [&](int c) { return neg_mul_add(low, p.z[c], q[c]); };
      return largest(below(0), below(1), below(2)) >= inside(-offset[1]) &&
             largest(above(0), above(1), above(2)) >= inside(offset[0]);
    };
    MB keep = in_front && p.z_low <= f.z_far &&
              (meets(p.x, planes.slope_u, f.offset_u) && meets(p.y, planes.slope_v, f.offset_v));
    if constexpr (kHasDiagonals<Rays>) {
      // Four triangles are often all left out by now; of more, some mostly stay.
      if (kLaneCount <= 4 && is_none<VB>(keep)) return keep;
      keep = keep && on_diagonals(f, planes.diagonals, p);
    }
    return keep;
  }

 private:
  static HWY_INLINE VB in_lanes(float number) { return set<VB>(number); }
  static HWY_INLINE VB in_lanes(VB lanes) { return lanes; }

  // The same for planes x + y = k z and x - y = k z with |k| <= 4: 2 u s for the roundings of two
  // corners, 4 u s for that of z and its product, 2 u s for that of the sum; 10 u s hold them.
  template <class Rays, class Bounds>
  static HWY_INLINE MB on_diagonals(const Rays& f, const Bounds& bounds, const Corners<VB>& p) {
    VB sums[3], differences[3];
    for (int c = 0; c < 3; ++c) {
      sums[c] = p.x[c] + p.y[c];
      differences[c] = p.x[c] - p.y[c];
    }
    const VB slack = set<VB>(f.reach * (-10 * kRoundoff));
    const auto meets = [&](const VB* q, const auto* bound) {
      const VB low = in_lanes(bound[0]), high = in_lanes(bound[1]);
      const auto below = [&](int c) { return mul_sub(high, p.z[c], q[c]); };
      const auto above = [&](int c) { return neg_mul_add(low, p.z[c], q[c]); };
      return min(largest(below(0), below(1), below(2)), largest(above(0), above(1), above(2))) >=
             slack;
    };
    return meets(sums, bounds.sum) && meets(differences, bounds.difference);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
