// SPDX-License-Identifier: Apache-2.0
// The triangles of a block that a frustum may meet: those with a corner on the inner side of each of
// its planes.
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
  using B = hn::CappedTag<float, W>;  // triangles
  using VB = hn::Vec<B>;
  using MB = hn::Mask<B>;

  static VB largest(VB p, VB q, VB r) { return hn::Max(hn::Max(p, q), r); }

  static HWY_INLINE Corners<VB> corners(const Frustum& f, const TriangleBlock<W>& block,
                                        size_t first) {
    const B b;
    Corners<VB> p;
    p.size = hn::Zero(b);
    for (int c = 0; c < 3; ++c) {
      const auto at = [&](int axis) {
        const VB corner = hn::Load(b, block.vertex[3 * c + axis] + first);
        return hn::Sub(corner, hn::Set(b, f.origin[axis]));
      };
      p.x[c] = at(f.kx);
      p.y[c] = at(f.ky);
      p.z[c] = hn::Mul(at(f.kz), hn::Set(b, f.side));
      p.size = hn::Max(p.size, largest(hn::Abs(p.x[c]), hn::Abs(p.y[c]), hn::Abs(p.z[c])));
    }
    p.z_low = hn::Min(hn::Min(p.z[0], p.z[1]), p.z[2]);
    return p;
  }

  // Triangles with a corner on the inner side of each plane. A lane without triangle is NaN and
  // fails the first comparison.
  static HWY_INLINE MB triangles(const Frustum& f, const Corners<VB>& p) {
    const B b;
    const MB in_front = hn::Ge(largest(p.z[0], p.z[1], p.z[2]), hn::Zero(b));
    // 4 u s for the roundings of a corner and of its product.
    const VB slack = hn::Mul(p.size, hn::Set(b, -4 * kRoundoff));
    const auto meets = [&](const VB* q, float slope, float offset, float sign) {
      const VB k = hn::Set(b, slope * sign), s = hn::Set(b, -sign);
      const auto inside = [&](int c) { return hn::MulAdd(k, p.z[c], hn::Mul(s, q[c])); };
      return hn::Ge(hn::Add(largest(inside(0), inside(1), inside(2)), hn::Set(b, offset * sign)),
                    slack);
    };
    const MB across = hn::And(meets(p.x, f.slope_u[1], f.offset_u[1], 1),
                              meets(p.x, f.slope_u[0], f.offset_u[0], -1));
    const MB up = hn::And(meets(p.y, f.slope_v[1], f.offset_v[1], 1),
                          meets(p.y, f.slope_v[0], f.offset_v[0], -1));
    return hn::And(hn::And(in_front, hn::Le(p.z_low, hn::Set(b, f.z_far))), hn::And(across, up));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
