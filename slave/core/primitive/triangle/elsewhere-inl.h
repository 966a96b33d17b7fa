// SPDX-License-Identifier: Apache-2.0
// Whether a ray meets the plane of a triangle where the triangle is not, in lanes of double: a
// cheap way to rule out triangles whose edges the ray passes too closely for a filter in float32. A
// mesh may be flatter than the tolerance of such a filter; a ray in it passes next to the edges of
// all triangles above and below its way, but it meets most of their planes far away.
//
// Bound. With w = 2^-53, P = N.(A - O), Q = N.D and t = P / Q: P and Q are off by less than
// kDeterminantError of the sizes of their terms. Where that is p of P and q of Q, t is off by less
// than (p + q) / (1 - q) of itself, which is less than 4/3 (p + q) for p + q < 1/4, and by the
// rounding of the quotient. The product with the direction and the differences have a rounding
// each, so 2 (p + q) + 8 w of the product are enough. A point of the triangle lies between the
// corners along each axis; what is further out by that bound is none. No number comes near the ends
// of double: all are products of up to four floats, or quotients of such. Where P, Q or both are
// zero, p + q is infinite or NaN, and nothing is known.
//
// Threads. Pure function.
#include "slave/core/primitive/triangle/exact_hit_abi.h"

#if defined(TESSERA_CORE_ELSEWHERE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_ELSEWHERE_INL_H_
#undef TESSERA_CORE_ELSEWHERE_INL_H_
#else
#define TESSERA_CORE_ELSEWHERE_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// corner(k): coordinate k of A, B, C, in [0, 9); origin(axis), direction(axis): of the ray; each a
// register of Doubles. Returns: the lanes whose ray surely misses its triangle.
template <class Corner, class Origin, class Direction>
HWY_INLINE MaskOf<Doubles> is_elsewhere(const Corner& corner, const Origin& origin,
                                        const Direction& direction) {
  Doubles a[3], b[3], c[3], low[3], high[3];
  for (size_t k = 0; k < 3; ++k) {
    const Doubles p = corner(k), q = corner(3 + k), r = corner(6 + k), from = origin(k);
    a[k] = p - from;
    b[k] = q - p;
    c[k] = r - p;
    low[k] = min(min(p, q), r) - from;
    high[k] = max(max(p, q), r) - from;
  }
  Doubles distance = set<Doubles>(0), speed = distance;
  Doubles distance_size = distance, speed_size = distance;
  for (size_t i = 0; i < 3; ++i) {
    const size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const Doubles one = b[j] * c[k], other = b[k] * c[j];
    const Doubles normal = one - other, size = abs(one) + abs(other);
    distance = distance + normal * a[i];
    distance_size = distance_size + size * abs(a[i]);
    speed = speed + normal * direction(i);
    speed_size = speed_size + size * abs(direction(i));
  }
  const Doubles t = distance / speed;
  const Doubles off = (distance_size / abs(distance) + speed_size / abs(speed)) * kDeterminantError;
  const Doubles share = off * 2 + 8 * 0x1p-53;
  auto is_out = t < t;  // in no lane yet
  for (size_t k = 0; k < 3; ++k) {
    const Doubles way = t * direction(k), slack = abs(way) * share;
    is_out = is_out || way + slack < low[k] || way - slack > high[k];
  }
  return is_out && off < 0.25;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
