// SPDX-License-Identifier: Apache-2.0
// What a transform may be refused for: numbers that are not finite, and maps without an inverse.
// Threads. Pure functions.
#pragma once

#include <cmath>
#include <cstddef>

#include "common/math/transform.h"

namespace tessera {

inline bool is_finite(const Transform& t) {
  for (const auto& row : t.m) {
    for (const float x : row) {
      if (!std::isfinite(x)) return false;
    }
  }
  return true;
}

// Whether the map has no inverse: its determinant is 0, or cannot be told from rounding. The six
// products of three and their sum in double have 3 + 5 roundings, and as many again are to spare.
inline bool is_singular(const Transform& t) {
  double determinant = 0, size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = [&](std::size_t row, std::size_t column) {
      return static_cast<double>(t.m[row][(i + column) % 3]);
    };
    const double a = at(0, 0) * (at(1, 1) * at(2, 2)), b = at(0, 0) * (at(1, 2) * at(2, 1));
    determinant += a - b;
    size += std::fabs(a) + std::fabs(b);
  }
  return !(std::fabs(determinant) > 16 * 0x1p-53 * size);
}

}  // namespace tessera
