// SPDX-License-Identifier: Apache-2.0
// Powers of two, logarithms and powers in float. Results are the same to the bit on every processor
// and C library, since they are arithmetic alone, in one order. T: float, or Floats.
//
// Error: log2() is off by at most 2^-22 where x is in [1/2, 2] and by roundings of the exponent
// beyond; exp2() is off by 4 * 2^-24 of itself, so that power(x, y) is off by some y * 2^-22 of
// itself (lobes_test.cpp).
//
// Threads. Pure functions.
#if defined(TESSERA_CORE_POWER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_POWER_INL_H_
#undef TESSERA_CORE_POWER_INL_H_
#else
#define TESSERA_CORE_POWER_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// Requires: x is finite, at least 2^-126 (what is less is taken for that).
template <class T>
TESSERA_INLINE T log2_of(T x) {
  using I = IntOf<T>;
  const I bits = bit_cast<I>(max(x, 1.17549435e-38f));
  // The exponent for which the mantissa is within a root of 2 from 1.
  const I exponent = shift_right<23>(bits - bit_cast<I>(set<T>(0.707106781f)));
  const T m = bit_cast<T>(bits - shift_left<23>(exponent));
  const T t = (m - 1) / (m + 1), t2 = t * t;
  const T series = 1 + t2 * (1 / 3.0f + t2 * (1 / 5.0f + t2 * (1 / 7.0f + t2 * (1 / 9.0f))));
  return convert<T>(exponent) + 2.88539008f * t * series;  // 2 / ln 2
}

// 2 to the power of x, bounded to [2^-126, 2^126].
template <class T>
TESSERA_INLINE T exp2_of(T x) {
  using I = IntOf<T>;
  const T inside = min(max(x, -126), 126);
  const T whole = floor(inside + 0.5f);
  const T a = (inside - whole) * 0.693147181f;  // ln 2
  const T series =
      1 + a * (1 + a * (1 / 2.0f +
                        a * (1 / 6.0f + a * (1 / 24.0f + a * (1 / 120.0f + a * (1 / 720.0f))))));
  return series * bit_cast<T>(shift_left<23>(convert<I>(whole) + 127));
}

// x to the power of y, y > 0; 0 where x is not above 0. Requires: both are finite.
template <class T>
TESSERA_INLINE T power(T x, T y) {
  return zero_unless(x > 0, exp2_of(y * log2_of(x)));
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
