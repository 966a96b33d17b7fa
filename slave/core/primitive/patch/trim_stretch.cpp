// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_stretch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera::core {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

// Ranges are this much wider than the piece: more than what an answer may be off by, 4 u, times
// sqrt(2), as |n| is at most that.
constexpr double kRoom = 0x1p-21;

}  // namespace

std::optional<TrimStretch> TrimStretch::of_cell(const TrimCells& cells, const TrimBox& cell,
                                                const TrimListed& of) {
  const TrimPiece& piece = cells.pieces[of.piece];
  // Ends on a border cut the cell in two as well; comparisons are exact. But points of the upper
  // borders of the whole square are in cells, too, and level with such an end no ray is crossed.
  for (int e = 0; e < 2; ++e) {
    const double u = piece.u[e], v = piece.v[e];
    if (u > cell.u[0] && (u < cell.u[1] || u >= 1) && v > cell.v[0] && (v < cell.v[1] || v >= 1))
      return std::nullopt;
  }
  const bool falls = piece.falls != 0;
  const auto* const coefficients = cells.coefficients.data();
  TrimStretch seen{of,
                   {decoded(piece.at[0]), piece.u[0], piece.v[0]},
                   {decoded(piece.at[1]), piece.u[1], piece.v[1]}};
  const auto enter = [&](bool of_v, double line) {
    const TrimEnd at = passage(piece, coefficients, of_v, line).low;
    if (at.v > seen.low.v) seen.low = at;
  };
  const auto leave = [&](bool of_v, double line) {
    const TrimEnd at = passage(piece, coefficients, of_v, line).high;
    if (at.v < seen.high.v) seen.high = at;
  };
  // Sides that the piece does not reach, it does not pass.
  const double first = cell.u[falls ? 1 : 0], last = cell.u[falls ? 0 : 1];
  const double u0 = piece.u[0], u1 = piece.u[1];
  if (std::min(u0, u1) >= cell.u[1] || std::max(u0, u1) <= cell.u[0]) return std::nullopt;
  if (piece.v[0] >= cell.v[1] || piece.v[1] <= cell.v[0]) return std::nullopt;
  if (falls ? u0 > first : u0 < first) enter(false, first);
  if (double{piece.v[0]} < cell.v[0]) enter(true, cell.v[0]);
  if (falls ? u1 < last : u1 > last) leave(false, last);
  if (double{piece.v[1]} > cell.v[1]) leave(true, cell.v[1]);
  if (!(seen.low.v <= seen.high.v)) return std::nullopt;
  return seen;
}

double TrimStretch::sums_off() const {
  return std::fabs(low.at.s + low.at.t - 1) + std::fabs(high.at.s + high.at.t - 1);
}

double TrimStretch::parameters() const {
  return std::max(std::fabs(high.at.s - low.at.s), std::fabs(high.at.t - low.at.t));
}

TrimInterval TrimInterval::around(double low, double high) {
  return {std::nextafter(static_cast<float>(low), -kInf),
          std::nextafter(static_cast<float>(high), kInf)};
}

// Of the corners of its ends' box, or of its chord and what it is away from that.
TrimInterval straight_values(const TrimStretch& seen, const TrimPiece& piece, double n_u,
                             double n_v) {
  const auto x = [&](double u, double v) { return n_u * u + n_v * v; };
  const double u_low = std::min(seen.low.u, seen.high.u);
  const double u_high = std::max(seen.low.u, seen.high.u);
  const bool is_left = n_u < 0;
  double low = x(is_left ? u_high : u_low, seen.low.v);
  double high = x(is_left ? u_low : u_high, seen.high.v);
  if (seen.sums_off() < 0x1p-48) {
    const double a = x(seen.low.u, seen.low.v), b = x(seen.high.u, seen.high.v);
    const double length = seen.parameters();
    const double away = double{piece.bend} * (length * length) * (std::fabs(n_u) + std::fabs(n_v));
    low = std::max(low, std::min(a, b) - away);
    high = std::min(high, std::max(a, b) + away);
  }
  return TrimInterval::around(low - kRoom, high + kRoom);
}

std::optional<TrimPlaces> TrimPlaces::of(const TrimStretch& seen, const TrimPiece& piece,
                                         const TrimCoefficient* coefficients) {
  if (!(seen.sums_off() < 0x1p-48 && std::isfinite(piece.bend))) return std::nullopt;
  TrimPlaces places;
  for (int i = 0; i <= kSteps; ++i) {
    const double share = i / double{kSteps};
    const TrimParameter at{seen.low.at.s + share * (seen.high.at.s - seen.low.at.s),
                           seen.low.at.t + share * (seen.high.at.t - seen.low.at.t)};
    places.at[i] = point_at(coefficients + piece.first, static_cast<int>(piece.degree), at);
  }
  places.at[0] = {seen.low.u, seen.low.v};
  places.at[kSteps] = {seen.high.u, seen.high.v};
  const double step = seen.parameters() / kSteps;
  places.away = double{piece.bend} * (step * step);
  return places;
}

TrimInterval TrimPlaces::with_room(double low, double high, double n_u, double n_v, double bend,
                                   double slope) const {
  double longest = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double step = n_v * (at[i + 1].u - at[i].u) - n_u * (at[i + 1].v - at[i].v);
    longest = std::max(longest, std::fabs(step));
  }
  const double off = away * (std::fabs(n_u) + std::fabs(n_v));
  const double room = slope * (off + kRoom) + 0.25 * std::fabs(bend) * (longest * longest);
  return TrimInterval::around(low - room, high + room);
}

}  // namespace tessera::core
