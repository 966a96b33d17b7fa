// SPDX-License-Identifier: Apache-2.0
// Bounds of what a sub-patch differs from a square by, and of its second derivatives.
// Threads. Pure functions.
#pragma once

#include "slave/core/primitive/patch/patch_net.h"

namespace tessera::core {

// What the nets of a sub-patch may be off by, of the largest coefficient: they come from halving,
// up to 2 kSubPatchLevelMax times, each time by at most 15 averages one after the other with one
// rounding each, 450 roundings of 2^-53. What is left to 512 is for the three roundings in which
// the first nets were made.
inline constexpr double kNetError = 0x1p-44;

// Beyond the square, at |x| = 1 + kSquareWiden, the absolute values of the Bernstein polynomials of
// degree d add up to (1 + kSquareWiden)^d <= 1 + 2^-15.9 for d <= 16, in two directions to less
// than 1 + kBeyond. So a polynomial exceeds its net's range by that factor at most, and a weight
// falls below its net's least by no more than kBeyond times the largest.
inline constexpr double kBeyond = 0x1p-14;

// By component. Infinite where weights of one sub-patch differ by a factor of 2^13 and more.
struct SubPatchBounds {
  double reach[3] = {};                       // of S - (x, y, 0)
  double xx[3] = {}, xy[3] = {}, yy[3] = {};  // of second derivatives by x and y
};

// local: w S in the frame, by component; w: the weights; error: what local may be off by, by
// component. Bounds hold for |x|, |y| <= 1 + kSquareWiden, and are good before they are rounded to
// float32: each has at most 2^6 roundings of double, for which a factor of 1 + kBeyond is left.
SubPatchBounds bounds_of(const PatchNet (&local)[3], const PatchNet& w, bool is_rational,
                         const double (&error)[3]);

// By component. Infinite likewise.
struct DerivativeBounds {
  double x[3] = {}, y[3] = {}, xx[3] = {}, xy[3] = {}, yy[3] = {};
};

// The same where local is in no frame: of first derivatives, too. The origin should be near the
// surface, for what weights make of its distance counts.
DerivativeBounds derivative_bounds_of(const PatchNet (&local)[3], const PatchNet& w,
                                      bool is_rational, const double (&error)[3]);

}  // namespace tessera::core
