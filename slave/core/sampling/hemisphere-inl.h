// SPDX-License-Identifier: Apache-2.0
// Directions about a normal. Results are the same to the bit on every processor and C library,
// since only arithmetic and square roots are used. T: float, or Floats.
// Threads. Pure functions.
#if defined(TESSERA_CORE_HEMISPHERE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_HEMISPHERE_INL_H_
#undef TESSERA_CORE_HEMISPHERE_INL_H_
#else
#define TESSERA_CORE_HEMISPHERE_INL_H_
#endif

#include "slave/core/simd/vec3-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// sin and cos of 2 pi x, x in [-1/8, 1/8]. Taylor series to the ninth and eighth power: off by less
// than 2^-24 there, so that it is the rounding of float32 that remains.
template <class T>
struct SinCos {
  T sin, cos;
};
template <class T>
TESSERA_INLINE SinCos<T> sin_cos_turn(T x) {
  const T a = 6.28318531f * x, b = a * a;
  return {a * (1 + b * (-1 / 6.0f + b * (1 / 120.0f + b * (-1 / 5040.0f + b * (1 / 362880.0f))))),
          1 + b * (-0.5f + b * (1 / 24.0f + b * (-1 / 720.0f + b * (1 / 40320.0f))))};
}

// sin and cos of 2 pi x, x in [0, 1].
template <class T>
TESSERA_INLINE SinCos<T> sin_cos_whole_turn(T x) {
  const auto quarter = convert<IntOf<T>>(4 * x + 0.5f);  // the nearest, 0 to 4
  const SinCos<T> t = sin_cos_turn(x - 0.25f * convert<T>(quarter));
  const auto is_odd = has_bit(quarter, 1);
  const T sin = select(is_odd, t.cos, t.sin), cos = select(is_odd, t.sin, t.cos);
  return {select(has_bit(quarter, 2), -sin, sin), select(has_bit(quarter + 1, 2), -cos, cos)};
}

// Maps the unit square onto the unit disk; neighbours stay neighbours (Shirley and Chiu, "A low
// distortion map between disk and square", 1997).
template <class T>
struct DiskPoint {
  T x, y;
};
template <class T>
TESSERA_INLINE DiskPoint<T> concentric_disk(T x, T y) {
  const T a = (x + x) - 1, b = (y + y) - 1;
  const auto is_wide = abs(a) > abs(b);
  const T longer = select(is_wide, a, b), shorter = select(is_wide, b, a);
  const auto is_middle = longer == 0;
  const SinCos<T> t = sin_cos_turn(shorter / longer * 0.125f);
  const T along = zero_if(is_middle, longer * t.cos), across = zero_if(is_middle, longer * t.sin);
  return {select(is_wide, along, across), select(is_wide, across, along)};
}

// Two unit vectors that are perpendicular to `n` and to each other (Duff et al., "Building an
// orthonormal basis, revisited", JCGT 6(1), 2017). Requires: n is of unit length.
template <class T>
struct Basis {
  Vec3<T> tangent, bitangent;
};
template <class T>
TESSERA_INLINE Basis<T> basis_about(Vec3<T> n) {
  const T sign = copy_sign(set<T>(1), n.z);
  const T a = -1 / (sign + n.z), b = n.x * n.y * a, signed_x = sign * n.x;
  return {{1 + signed_x * n.x * a, sign * b, -signed_x}, {b, sign + n.y * n.y * a, -n.y}};
}

// A direction of pdf cosine / pi about `normal`. x, y: in the unit square, which is mapped onto the
// disk.
template <class T>
TESSERA_INLINE Vec3<T> cosine_direction(Vec3<T> normal, T x, T y) {
  const DiskPoint<T> disk = concentric_disk(x, y);
  const T height = sqrt(max(set<T>(0), 1 - disk.x * disk.x - disk.y * disk.y));
  const Basis<T> basis = basis_about(normal);
  return basis.tangent * disk.x + basis.bitangent * disk.y + normal * height;
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
