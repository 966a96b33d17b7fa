// SPDX-License-Identifier: Apache-2.0
// Bounds on rounding error; the source of every tolerance in the renderer.
// Threads. Constants and pure functions. All bounds assume round-to-nearest and no contraction,
// which the build enforces with -ffp-contract=off.
#pragma once

#include <limits>

namespace tessera {

// Largest relative error of one rounding to nearest: half the gap between 1 and the next float,
// 2^-24.
inline constexpr float kUnitRoundoff = std::numeric_limits<float>::epsilon() / 2;

// Bound on the relative error after n roundings: |computed - exact| <= gamma(n) * |exact|.
// Higham, "Accuracy and Stability of Numerical Algorithms", 2nd ed. 2002, section 3.1.
// Requires: n * 2^-24 < 1. Count the roundings in the expression; do not tune n until an image
// looks right.
constexpr float gamma(int n) {
  const float nu = static_cast<float>(n) * kUnitRoundoff;
  return nu / (1 - nu);
}

}  // namespace tessera
