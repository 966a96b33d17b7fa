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

// Corners of W triangles, seen from the origin of a frustum; size: the largest coordinate of each.
template <class VB>
struct Corners {
  VB x[3], y[3], z[3], size, z_low;
};

template <int W>
struct FrustumTriangles {
  using VB = FloatsOf<W>;  // triangles
  using MB = MaskOf<VB>;

  static VB largest(VB p, VB q, VB r) { return max(max(p, q), r); }

  static HWY_INLINE Corners<VB> corners(const Frustum& f, const TriangleBlock<W>& block,
                                        size_t first) {
    Corners<VB> p;
    p.size = set<VB>(0);
    for (int c = 0; c < 3; ++c) {
      const auto at = [&](int axis) {
        const VB corner = load<VB>(block.vertex[3 * c + axis] + first);
        return corner - f.origin[axis];
      };
      p.x[c] = at(f.kx);
      p.y[c] = at(f.ky);
      p.z[c] = at(f.kz) * f.side;
      p.size = max(p.size, largest(abs(p.x[c]), abs(p.y[c]), abs(p.z[c])));
    }
    p.z_low = min(min(p.z[0], p.z[1]), p.z[2]);
    return p;
  }

  // Triangles with a corner on the inner side of each plane. A lane without triangle is NaN and
  // fails the first comparison.
  template <class Rays>
  static HWY_INLINE MB triangles(const Rays& f, const Corners<VB>& p) {
    const MB in_front = largest(p.z[0], p.z[1], p.z[2]) >= 0;
    // 4 u s for the roundings of a corner and of its product.
    const VB slack = p.size * (-4 * kRoundoff);
    const auto meets = [&](const VB* q, float slope, float offset, float sign) {
      const VB k = set<VB>(slope * sign), s = set<VB>(-sign);
      const auto inside = [&](int c) { return mul_add(k, p.z[c], s * q[c]); };
      return largest(inside(0), inside(1), inside(2)) + offset * sign >= slack;
    };
    const MB across =
        meets(p.x, f.slope_u[1], f.offset_u[1], 1) && meets(p.x, f.slope_u[0], f.offset_u[0], -1);
    const MB up =
        meets(p.y, f.slope_v[1], f.offset_v[1], 1) && meets(p.y, f.slope_v[0], f.offset_v[0], -1);
    MB keep = in_front && p.z_low <= f.z_far && (across && up);
    if constexpr (kHasDiagonals<Rays>) keep = keep && on_diagonals(f.diagonals, p);
    return keep;
  }

 private:
  // The same for planes x + y = k z and x - y = k z with |k| <= 4: 2 u s for the roundings of two
  // corners, 4 u s for that of z and its product, 2 u s for that of the sum; 10 u s hold them.
  static HWY_INLINE MB on_diagonals(const Diagonals& d, const Corners<VB>& p) {
    VB sums[3], differences[3];
    for (int c = 0; c < 3; ++c) {
      sums[c] = p.x[c] + p.y[c];
      differences[c] = p.x[c] - p.y[c];
    }
    const VB slack = p.size * (-10 * kRoundoff);
    const auto meets = [&](const VB* q, const float* bound) {
      const VB low = set<VB>(bound[0]), high = set<VB>(bound[1]);
      const auto below = [&](int c) { return mul_sub(high, p.z[c], q[c]); };
      const auto above = [&](int c) { return neg_mul_add(low, p.z[c], q[c]); };
      return min(largest(below(0), below(1), below(2)), largest(above(0), above(1), above(2))) >=
             slack;
    };
    return meets(sums, d.sum) && meets(differences, d.difference);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
