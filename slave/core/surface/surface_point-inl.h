// SPDX-License-Identifier: Apache-2.0
// How far a secondary ray must start from a surface to be on the right side of it for certain.
// T: float, or Floats.
//
// With u = 2^-24, triangle A, B, C, unit normal n, and P = A + (a (B - A) + b (C - A)) in float32:
//   - P against the exact plane, by component: difference, product and sum are 3 roundings of each
//     edge term, the last sum is one rounding of P: gamma(3) (|a (B-A)| + |b (C-A)|) + gamma(1)
//     |P|. Errors of a and b themselves move P within the plane and do not count.
//   - Adding the offset rounds once more: gamma(1) |P|; roundings of this bound: gamma(2) |P| in
//     all.
//   - The triangle test sees the plane displaced by its own error: a vertex at distance s from the
//     origin is moved by at most 6 u s when it is brought to the ray's frame, and the products of
//     the edge values move the point by another 2 u s for well-shaped triangles; twice that, 16 u
//     s, the tolerance of the whole project, also covers triangles of aspect up to about 4. s is
//     the largest component of the distance from P to a vertex.
// The distance to the plane counts, not the distance along the ray: at a grazing angle both the
// displacement and the offset grow by 1 / cos when measured along the ray.
//
// Threads. Pure functions.
#if defined(TESSERA_CORE_SURFACE_POINT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_SURFACE_POINT_INL_H_
#undef TESSERA_CORE_SURFACE_POINT_INL_H_
#else
#define TESSERA_CORE_SURFACE_POINT_INL_H_
#endif

#include "slave/core/simd/vec3-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// gamma() of common/math/rounding.h.
constexpr float gamma_of(int n) {
  const float nu = static_cast<float>(n) * kRoundoff;
  return nu / (1 - nu);
}

// Whether the edges from A make an angle whose sine is below 2^-8: |b x c| < 2^-8 |b| |c|. The
// normal of any other triangle is good to 2^-14: a component of the product is off by 3 u |b| |c|,
// all of them by sqrt(3) as much, that is 5.2 u 2^8 of its length. It is also true where products
// under- or overflow.
constexpr float kSliverSine2 = 0x1p-16f;
template <class T>
TESSERA_INLINE auto is_sliver(Vec3<T> edge_b, Vec3<T> edge_c) {
  const Vec3<T> across = cross(edge_b, edge_c);
  return !(dot(across, across) >= kSliverSine2 * (dot(edge_b, edge_b) * dot(edge_c, edge_c)));
}

template <class T>
struct SurfacePoint {
  Vec3<T> point;
  T offset;  // along the unit normal, at least this far
};

// A + u B + v C of a triangle with edges B and C from A.
template <class T>
TESSERA_INLINE SurfacePoint<T> surface_point(Vec3<T> a, Vec3<T> edge_b, Vec3<T> edge_c,
                                             Vec3<T> normal, T u, T v) {
  const Vec3<T> along_b = edge_b * u, along_c = edge_c * v;
  const Vec3<T> within = along_b + along_c;
  const Vec3<T> point = a + within;
  const Vec3<T> error =
      (abs(along_b) + abs(along_c)) * set<T>(gamma_of(3)) + abs(point) * set<T>(gamma_of(4));
  const T reach =
      max(max(largest(abs(within)), largest(abs(edge_b - within))), largest(abs(edge_c - within)));
  return {point, dot(abs(normal), error) + 16 * kRoundoff * reach};
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
