// SPDX-License-Identifier: Apache-2.0
// Powers of two, logarithms and powers in float. The same bits on every processor and C library: arithmetic
// alone, in one order (slave/core/simd/power-inl.h has the same in lanes).
//
// Error: log2() is off by at most 2^-22 where x is in [1/2, 2] and by roundings of the exponent beyond;
// exp2() is off by 4 * 2^-24 of itself, so that power(x, y) is off by some y * 2^-22 of itself
// (power_test.cpp).
//
// Threads. Pure functions.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace tessera {

// Requires: x is finite, at least 2^-126 (what is less is taken for that).
inline float log2_of(float x) {
  constexpr float kHalfRoot = 0.707106781f, kScale = 2.88539008f;  // 2 / ln 2
  const auto bits = std::bit_cast<std::int32_t>(std::max(x, 1.17549435e-38f));
  // The exponent for which the mantissa is within a root of 2 from 1.
  const std::int32_t exponent = (bits - std::bit_cast<std::int32_t>(kHalfRoot)) >> 23;
  const float m = std::bit_cast<float>(bits - (exponent << 23));
  const float t = (m - 1) / (m + 1), t2 = t * t;
  const float series = 1 + t2 * (1 / 3.0f + t2 * (1 / 5.0f + t2 * (1 / 7.0f + t2 * (1 / 9.0f))));
  return static_cast<float>(exponent) + kScale * t * series;
}

// Bounded to [2^-126, 2^126].
inline float exp2_of(float x) {
  constexpr float kLn2 = 0.693147181f;
  const float inside = std::min(std::max(x, -126.0f), 126.0f);
  const float whole = std::floor(inside + 0.5f);
  const float a = (inside - whole) * kLn2;
  const float series =
      1 + a * (1 + a * (1 / 2.0f +
                        a * (1 / 6.0f + a * (1 / 24.0f + a * (1 / 120.0f + a * (1 / 720.0f))))));
  return series * std::bit_cast<float>((static_cast<std::int32_t>(whole) + 127) << 23);
}

// x to the power of y. Requires: x >= 0, y >= 0, both finite. 0 to the power of 0 is 1.
inline float power(float x, float y) {
  if (y == 0) return 1;
  return x > 0 ? exp2_of(y * log2_of(x)) : 0;
}

}  // namespace tessera
