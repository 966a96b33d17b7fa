// SPDX-License-Identifier: Apache-2.0
// Cuts segments of trimming loops where u or v turns back, into pieces along which neither does.
//
// A curve crosses a line no more often than its control polygon, weights > 0 (variation
// diminishing: Farin, chapter 13), so where the u of a part's control points rise or fall, by
// kTrimTurn at most back, its u does, and so v. A part of which that is not known is halved; close
// to an extremum parts end that are flat, of kTrimTurn in u or v. Parts one after the other are
// joined while they go on the same way. No derivative is taken, so nothing cancels (trim_curve.h).
//
// How many. A segment of degree n has at most 4 (n - 1) places where u or v turns, and 4 n - 3
// pieces. Halving goes on kTrimDepthMax deep at most, and about 14 deep at a place where weights
// are alike: t^2 = 2^-28.
//
// Threads. Pure functions.
#pragma once

#include <span>
#include <vector>

#include "slave/core/primitive/patch/trim_piece.h"

namespace tessera::core {

// 305 halves until weights of float32 are out of play (2^277) and what is left of t is below 2^-28,
// then 28 + 4 for that part; at the bound a part counts as flat. Such segments only tests have.
inline constexpr int kTrimDepthMax = 400;

// Appends the pieces of one segment. points: [degree + 1], the ends among them; first: place of its
// coefficients. What begins and ends in one place is left out.
// Requires: 1 <= degree <= kTrimDegreeMax; finite coordinates in [0, 1], weights > 0 and finite.
void split_segment(std::span<const TrimPoint> points, std::uint32_t first,
                   std::vector<TrimPiece>& to);

}  // namespace tessera::core
