// SPDX-License-Identifier: Apache-2.0
// A part of a segment of a trimming loop along which neither u nor v turns back, and on which side
// of it a point lies.
//
// What is decided. Not the segment itself but a curve with the same ends near it: parity of
// crossings is that of the segment for every point that the one does not pass when it is moved into
// the other, so a bound on the distance is all that an answer needs. u = 2^-24 below.
// - A piece turns back by 2 kTrimTurn at most, in u and in v (trim_splitting.h), and its ends are
//   rounded to float32, by 2^-25 at most: what remains within the box of its ends is moved by less
//   than sqrt(2) (2^-25 + 2^-27) < 0.9 u.
// - The piece lies in a band along its chord; a point beside the band is on the side of the chord
//   that it is on (the fat line of T. Sederberg, T. Nishita, "Curve intersection using Bezier
//   clipping", CAD 22, 1990).
// - A point in the band is decided by halves of the piece: one of them begins and ends on one side
//   in v and does not count, but for roundings of 2^-46; the other has a chord that it is as near
//   to as second derivatives say, |C - chord| <= max |C''| h^2 / 8 for a length h of parameter. It
//   ends at the latest where what is left has sides of kTrimResolution or less, so that a point
//   within is nearer than 2.9 u.
// Together less than 3.8 u: a point further than 4 u from the piece is always right.
//
// Half open. A piece counts for a ray towards +u where v_low <= v < v_high, so two that meet at an
// end count once where the curve goes on upwards and twice or never where it turns back, to the
// bit, and one that is horizontal never counts.
//
// Work. At most kTrimStepsMax points of the segment; 2 or 3 in the mean of what lies in the band.
// As a half is four times nearer to its chord, a point at a distance of 4 u takes some 10.
//
// Threads. Pure functions of plain values. The same bits on every instruction set: plain double.
#pragma once

#include <cstdint>

#include "slave/core/primitive/patch/trim_curve.h"

namespace tessera::core {

inline constexpr double kTrimTurn = 0x1p-28;
inline constexpr double kTrimResolution = 0x1p-23;

// Halves by parameter: 24 bits of place, 4 of degree, 12 of weights that differ. What needs more is
// halved by the digits of the parameter.
inline constexpr int kTrimEvenSteps = 40;
inline constexpr int kTrimStepsMax = kTrimEvenSteps + 64;

// 48 bytes. Ends are in the order of v, from low to high.
struct TrimPiece {
  float u[2], v[2];
  double at[2];               // parameters: t up to one half, else -s (encoded())
  float band_low, band_high;  // of (u - u[0]) (v[1] - v[0]) - (v - v[0]) (u[1] - u[0])
  float bend;                 // bound of |u''| / 8 and |v''| / 8 by t, for s + t = 1; or infinite
  std::uint32_t first : 27;   // of its segment's coefficients
  std::uint32_t degree : 4;
  std::uint32_t falls : 1;  // u falls where v rises
};
static_assert(sizeof(TrimPiece) == 48);

inline constexpr std::uint32_t kTrimCoefficientsMax = 1u << 27;

// What an answer cost.
struct TrimSteps {
  // Grids and places of an order; pieces; points of pieces.
  std::uint64_t cells = 0, pieces = 0, points = 0;
};

double encoded(TrimParameter at);
TrimParameter decoded(double at);

// Whether a ray from (u, v) towards +u crosses the piece. coefficients: of all segments. Adds
// points of the segment that it took.
bool crosses(const TrimPiece& piece, const TrimCoefficient* coefficients, double u, double v,
             std::uint64_t& points);

// Where the piece passes a line u = const: v, off by 2^-26 at most, between its ends.
// Requires: u between the piece's ends, or at one of them.
double v_at(const TrimPiece& piece, const TrimCoefficient* coefficients, double u);

// A point of a piece.
struct TrimEnd {
  TrimParameter at;
  double u, v;
};

// Two points of a piece as near to each other as v_at() needs, between which it passes the line
// v = const (or u = const), from low to high v. Requires: that it does.
struct TrimPassage {
  TrimEnd low, high;
};
TrimPassage passage(const TrimPiece& piece, const TrimCoefficient* coefficients, bool of_v,
                    double line);

// Whether the piece may come nearer than `margin` in u and in v. Requires: a margin of 2^-21 and
// more in each, twice what an answer may be off by, so that an answer that is sure is right.
bool is_near(const TrimPiece& piece, const TrimCoefficient* coefficients, TrimPlace to,
             TrimPlace margin);

}  // namespace tessera::core
