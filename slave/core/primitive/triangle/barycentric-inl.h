// SPDX-License-Identifier: Apache-2.0
// Barycentric coordinates of hits, for those that are kept in the end: kernels decide and compare
// without them. T: double, or a register of doubles.
//
// P = (1 - u - v) A + u B + v C; u, v and 1 - u - v are in [0, 1] whatever the rounding. The
// computation is relative to A. Its error is some 2^-50 s over the triangle's height as the ray
// sees it, with s the distance of the ray's origin from A. One object serves rays from one origin.
//
// After Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
//
// Threads. Pure functions.
#if defined(TESSERA_CORE_BARYCENTRIC_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_BARYCENTRIC_INL_H_
#undef TESSERA_CORE_BARYCENTRIC_INL_H_
#else
#define TESSERA_CORE_BARYCENTRIC_INL_H_
#endif

#include "slave/core/simd/vec3-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

template <class T>
class Barycentric {
 public:
  struct Coordinates {
    FloatOf<T> u, v;
  };

  TESSERA_INLINE Barycentric(Vec3<T> origin, Vec3<T> a, Vec3<T> b, Vec3<T> c)
      : edge_b_(b - a), edge_c_(c - a), from_(origin - a), across_(cross(from_, edge_b_)) {}

  // Requires: the ray meets the triangle.
  TESSERA_INLINE Coordinates of(Vec3<T> direction) const {
    const Vec3<T> p = cross(direction, edge_c_);
    const T volume = dot(edge_b_, p);
    // A hit triangle is never seen edge-on; the products of its extents may vanish all the same.
    const auto is_there = volume != 0;
    const auto share = [&](T value) {
      const T within = min(max(value / volume, 0), 1);
      return convert<FloatOf<T>>(zero_unless(is_there, within + 0));  // no -0
    };
    const FloatOf<T> u = share(dot(from_, p)), v = share(dot(direction, across_));
    return {u, min(v, 1 - u)};
  }

 private:
  Vec3<T> edge_b_, edge_c_, from_, across_;
};

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
