// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_piece.h"

#include <algorithm>
#include <cmath>

namespace tessera::core {
namespace {

// What is left of a piece between two of its points.
struct Rest {
  TrimEnd low, high;

  explicit Rest(const TrimPiece& piece)
      : low{decoded(piece.at[0]), piece.u[0], piece.v[0]},
        high{decoded(piece.at[1]), piece.u[1], piece.v[1]} {}

  double u_low() const { return std::min(low.u, high.u); }
  double u_high() const { return std::max(low.u, high.u); }

  // How far (u, v) is towards +u from the chord, times the chord's height.
  double side_of(double u, double v) const {
    return (u - low.u) * (high.v - low.v) - (v - low.v) * (high.u - low.u);
  }

  // Bound on side_of() for points of the curve. Requires: parameters with s + t = 1.
  double band(double bend) const {
    const double length =
        std::max(std::fabs(high.at.s - low.at.s), std::fabs(high.at.t - low.at.t));
    const double away = bend * (length * length);
    return away * (std::fabs(high.u - low.u) + std::fabs(high.v - low.v));
  }

  TrimEnd halfway(const TrimPiece& piece, const TrimCoefficient* coefficients, int step) const {
    const TrimParameter at =
        step < kTrimEvenSteps ? middle(low.at, high.at) : geometric_middle(low.at, high.at);
    const TrimPlace place =
        point_at(coefficients + piece.first, static_cast<int>(piece.degree), at);
    return {at, place.u, place.v};
  }
};

// In the band. The loop ends: see kTrimStepsMax.
bool crosses_in_band(const TrimPiece& piece, const TrimCoefficient* coefficients, double u,
                     double v, std::uint64_t& points) {
  Rest rest(piece);
  for (int step = 0; step < kTrimStepsMax; ++step) {
    if (rest.u_high() - rest.u_low() <= kTrimResolution &&
        rest.high.v - rest.low.v <= kTrimResolution)
      break;
    ++points;
    const TrimEnd half = rest.halfway(piece, coefficients, step);
    (half.v <= v ? rest.low : rest.high) = half;
    if (u < rest.u_low()) return true;
    if (u >= rest.u_high()) return false;
    if (step + 1 >= kTrimEvenSteps) continue;
    const double side = rest.side_of(u, v), band = rest.band(double{piece.bend});
    if (side < -band) return true;
    if (side > band) return false;
  }
  return u < 0.5 * (rest.low.u + rest.high.u);
}

}  // namespace

double encoded(TrimParameter at) { return at.t <= 0.5 ? at.t : -at.s; }

TrimParameter decoded(double at) {
  if (std::signbit(at)) return {-at, 1 + at};
  return {1 - at, at};
}

bool crosses(const TrimPiece& piece, const TrimCoefficient* coefficients, double u, double v,
             std::uint64_t& points) {
  if (!(piece.v[0] <= v && v < piece.v[1])) return false;
  const double u0 = piece.u[0], u1 = piece.u[1], v0 = piece.v[0], v1 = piece.v[1];
  if (u < std::min(u0, u1)) return true;
  if (u >= std::max(u0, u1)) return false;
  const double side = (u - u0) * (v1 - v0) - (v - v0) * (u1 - u0);
  if (side < double{piece.band_low}) return true;
  if (side > double{piece.band_high}) return false;
  return crosses_in_band(piece, coefficients, u, v, points);
}

TrimPassage passage(const TrimPiece& piece, const TrimCoefficient* coefficients, bool of_v,
                    double line) {
  Rest rest(piece);
  for (int step = 0; step < kTrimStepsMax && rest.high.v - rest.low.v > 0x1p-27; ++step) {
    const TrimEnd half = rest.halfway(piece, coefficients, step);
    const bool is_before = of_v ? half.v < line : piece.falls != 0 ? half.u >= line : half.u < line;
    (is_before ? rest.low : rest.high) = half;
  }
  return {rest.low, rest.high};
}

double v_at(const TrimPiece& piece, const TrimCoefficient* coefficients, double u) {
  const TrimPassage at = passage(piece, coefficients, false, u);
  const double v = 0.5 * (at.low.v + at.high.v);
  return std::clamp(v, double{piece.v[0]}, double{piece.v[1]});
}

bool is_near(const TrimPiece& piece, const TrimCoefficient* coefficients, TrimPlace to,
             TrimPlace margin) {
  const double u_low = std::min(piece.u[0], piece.u[1]), u_high = std::max(piece.u[0], piece.u[1]);
  if (to.u < u_low - margin.u || to.u > u_high + margin.u) return false;
  if (to.v < double{piece.v[0]} - margin.v || to.v > double{piece.v[1]} + margin.v) return false;
  // Level with an end, the answer of a corner would be the end's.
  if (to.v - margin.v < double{piece.v[0]} || to.v + margin.v >= double{piece.v[1]}) return true;
  // The piece runs from one quadrant to the opposite one, and passes between the other two.
  const double across = piece.falls != 0 ? -margin.v : margin.v;
  std::uint64_t points = 0;
  return crosses(piece, coefficients, to.u - margin.u, to.v + across, points) !=
         crosses(piece, coefficients, to.u + margin.u, to.v - across, points);
}

}  // namespace tessera::core
