// SPDX-License-Identifier: Apache-2.0
// Points of a segment of a trimming loop: a rational Bezier curve in a patch's square (G. Farin,
// Curves and Surfaces for CAGD, 5th ed., 2002, chapter 13), of degree 1 to 15.
//
// Errors. Coordinates and weights are not below 0 and parameters are kept from both ends, so every
// sum has terms of one sign: nothing cancels. A numerator and a denominator have at most 4 degree
// + 2 roundings each, hence a point is off by less than 124 * 2^-53 < 2^-46 in u and in v, whatever
// the weights are. A rounding of s or t moves a point by at most 2 degree 2^-53 as well. Terms that
// underflow are below 2^-600 of the sum.
//
// Threads. Pure functions.
#pragma once

#include <cstdint>

#include "common/scene/patch_surface.h"

namespace tessera::core {

inline constexpr int kTrimDegreeMax = kPatchDegreesMax;

// The parameter t / (s + t), with all digits near both ends. s, t >= 0, not both 0.
struct TrimParameter {
  double s = 1, t = 0;
};

// A control point i of a segment of degree n: C(n, i) w u, C(n, i) w v, C(n, i) w. Its first and
// last are the ends themselves, so that the last one is the first one of the segment that follows.
struct TrimCoefficient {
  double u, v, w;
};

struct TrimPlace {
  double u, v;
};

TrimCoefficient coefficient_of(const TrimPoint& point, int degree, int index);

// Shape: coefficients [degree + 1].
inline TrimPlace point_at(const TrimCoefficient* coefficients, int degree, TrimParameter at) {
  TrimCoefficient sum = coefficients[0];
  double power = 1;
  for (int i = 1; i <= degree; ++i) {
    const TrimCoefficient& c = coefficients[i];
    power = power * at.t;
    sum = {sum.u * at.s + c.u * power, sum.v * at.s + c.v * power, sum.w * at.s + c.w * power};
  }
  return {sum.u / sum.w, sum.v / sum.w};
}

// Halfway. Requires: both have s + t = 1 but for roundings; so has what it returns.
inline TrimParameter middle(TrimParameter a, TrimParameter b) {
  return {0.5 * (a.s + b.s), 0.5 * (a.t + b.t)};
}

// Halfway in the digits of t / s: after 64 such halves nothing lies between two parameters, however
// many powers of two they are apart. What it returns has not s + t = 1.
TrimParameter geometric_middle(TrimParameter a, TrimParameter b);

}  // namespace tessera::core
