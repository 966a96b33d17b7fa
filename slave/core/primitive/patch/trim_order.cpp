// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tessera::core {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

// Ranges are this much wider than the piece: more than what an answer may be off by, 4 u, times
// sqrt(2), as |n| is at most that.
constexpr double kRoom = 0x1p-21;

// What a cell sees of a piece, or some more.
struct Stretch {
  TrimListed of;
  TrimEnd low, high;
};

std::optional<Stretch> stretch_of(const TrimCells& cells, const TrimBox& cell,
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
  Stretch seen{of,
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

// How far the parameters of its ends are from having the sum 1, and how far they are apart.
double sums_off(const Stretch& seen) {
  return std::fabs(seen.low.at.s + seen.low.at.t - 1) +
         std::fabs(seen.high.at.s + seen.high.at.t - 1);
}
double parameters_of(const Stretch& seen) {
  return std::max(std::fabs(seen.high.at.s - seen.low.at.s),
                  std::fabs(seen.high.at.t - seen.low.at.t));
}

// Of the corners of its ends' box, or of its chord and what it is away from that.
TrimRange range_of(const Stretch& seen, const TrimPiece& piece, double n_u, double n_v) {
  const auto x = [&](double u, double v) { return n_u * u + n_v * v; };
  const double u_low = std::min(seen.low.u, seen.high.u);
  const double u_high = std::max(seen.low.u, seen.high.u);
  const bool is_left = n_u < 0;
  double low = x(is_left ? u_high : u_low, seen.low.v);
  double high = x(is_left ? u_low : u_high, seen.high.v);
  if (sums_off(seen) < 0x1p-48) {
    const double a = x(seen.low.u, seen.low.v), b = x(seen.high.u, seen.high.v);
    const double length = parameters_of(seen);
    const double away = double{piece.bend} * (length * length) * (std::fabs(n_u) + std::fabs(n_v));
    low = std::max(low, std::min(a, b) - away);
    high = std::min(high, std::max(a, b) + away);
  }
  return {std::nextafter(static_cast<float>(low - kRoom), -kInf),
          std::nextafter(static_cast<float>(high + kRoom), kInf), 0};
}

// As nearly as a parabola goes along what the cell sees. Between two of its places the piece is
// within its bend of their chord, and the parabola within |bend| h^2 / 4, for a length h by y.
std::optional<TrimCourse> parabola_of(const Stretch& seen, const TrimPiece& piece,
                                      const TrimCoefficient* coefficients, TrimCourse course) {
  constexpr int kSteps = 8;
  if (!(sums_off(seen) < 0x1p-48 && std::isfinite(piece.bend))) return std::nullopt;
  const auto y_of = [&](TrimPlace p) {
    return double{course.n_v} * p.u - double{course.n_u} * p.v;
  };
  TrimPlace places[kSteps + 1];
  for (int i = 0; i <= kSteps; ++i) {
    const double share = i / double{kSteps};
    const TrimParameter at{seen.low.at.s + share * (seen.high.at.s - seen.low.at.s),
                           seen.low.at.t + share * (seen.high.at.t - seen.low.at.t)};
    places[i] = point_at(coefficients + piece.first, static_cast<int>(piece.degree), at);
  }
  places[0] = {seen.low.u, seen.low.v};
  places[kSteps] = {seen.high.u, seen.high.v};
  const double from = y_of(places[0]), to = y_of(places[kSteps]);
  course.at = static_cast<float>(0.5 * (from + to));
  course.reach = static_cast<float>(0.5 * std::fabs(to - from));
  const TrimPlace middle = places[kSteps / 2];
  const double ends = 0.5 * (course.across(places[0].u, places[0].v) +
                             course.across(places[kSteps].u, places[kSteps].v));
  const double square = double{course.reach} * double{course.reach};
  course.bend = static_cast<float>((ends - course.across(middle.u, middle.v)) / square);
  const double bend = std::fabs(double{course.bend}), slope = 1 + 2 * bend * double{course.reach};
  if (!(slope < 4)) return std::nullopt;
  double low = kInf, high = -kInf, longest = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = course.across(places[i].u, places[i].v);
    low = std::min(low, x);
    high = std::max(high, x);
    if (i > 0) longest = std::max(longest, std::fabs(y_of(places[i]) - y_of(places[i - 1])));
  }
  const double step = parameters_of(seen) / kSteps;
  const double away = double{piece.bend} * (step * step) *
                      (std::fabs(double{course.n_u}) + std::fabs(double{course.n_v}));
  const double room = slope * (away + kRoom) + 0.25 * bend * (longest * longest);
  course.low = std::nextafter(static_cast<float>(low - room), -kInf);
  course.high = std::nextafter(static_cast<float>(high + room), kInf);
  return course;
}

}  // namespace

void set_course(const TrimCells& cells, const TrimBox& cell, TrimListed& of) {
  const std::optional<Stretch> seen = stretch_of(cells, cell, of);
  if (!seen.has_value()) return;
  const TrimPiece& piece = cells.pieces[of.piece];
  const double du = std::fabs(seen->high.u - seen->low.u), dv = seen->high.v - seen->low.v;
  const double most = std::max(du, dv);
  if (!(most > 0)) return;
  TrimCourse course;
  course.n_u = static_cast<float>((piece.falls != 0 ? dv : -dv) / most);
  course.n_v = static_cast<float>(du / most);
  const TrimRange range = range_of(*seen, piece, double{course.n_u}, double{course.n_v});
  const auto parabola = parabola_of(*seen, piece, cells.coefficients.data(), course);
  course.low = range.low;
  course.high = range.high;
  const bool is_nearer = parabola && parabola->high - parabola->low < course.high - course.low;
  of.course = is_nearer ? *parabola : course;
}

std::optional<std::uint32_t> add_order(TrimCells& to, const TrimBox& cell,
                                       const std::vector<TrimListed>& list, std::size_t few) {
  std::vector<Stretch> rising, falling;
  std::vector<TrimListed> others;
  for (const TrimListed& of : list) {
    const std::optional<Stretch> seen = stretch_of(to, cell, of);
    if (!seen.has_value()) {
      others.push_back(of);
    } else {
      (to.pieces[of.piece].falls != 0 ? falling : rising).push_back(*seen);
    }
  }
  const bool are_rising = rising.size() >= falling.size();
  const std::vector<Stretch>& chosen = are_rising ? rising : falling;
  if (chosen.size() <= few) return std::nullopt;
  for (const Stretch& seen : are_rising ? falling : rising) others.push_back(seen.of);

  TrimOrder order{};
  double du = 0, dv = 0;
  for (const Stretch& seen : chosen) {
    du += std::fabs(seen.high.u - seen.low.u);
    dv += std::max(0.0, seen.high.v - seen.low.v);
  }
  const double most = std::max(du, dv);
  if (!(most > 0)) return std::nullopt;
  order.n_u = (are_rising ? -dv : dv) / most;
  order.n_v = du / most;
  order.first = static_cast<std::uint32_t>(to.listed.size());
  order.ordered = static_cast<std::uint32_t>(chosen.size());
  order.range = static_cast<std::uint32_t>(to.ranges.size());
  std::vector<std::pair<TrimRange, TrimListed>> sorted;
  for (const Stretch& seen : chosen)
    sorted.emplace_back(range_of(seen, to.pieces[seen.of.piece], order.n_u, order.n_v), seen.of);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first.low < b.first.low; });
  float high = -kInf;
  for (auto& [range, of] : sorted) {
    range.high_so_far = high = std::max(high, range.high);
    to.ranges.push_back(range);
    to.listed.push_back(of);
  }
  to.listed.insert(to.listed.end(), others.begin(), others.end());
  to.orders.push_back(order);
  return static_cast<std::uint32_t>(to.orders.size() - 1);
}

}  // namespace tessera::core
