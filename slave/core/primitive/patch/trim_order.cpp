// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace tessera::core {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

// As nearly as a parabola goes along what the cell sees.
std::optional<TrimCourse> parabola_of(const TrimPlaces& places, TrimCourse course) {
  const auto y_of = [&](TrimPlace p) {
    return double{course.n_v} * p.u - double{course.n_u} * p.v;
  };
  const TrimPlace first = places.first(), middle = places.middle(), last = places.last();
  const double from = y_of(first), to = y_of(last);
  course.at = static_cast<float>(0.5 * (from + to));
  course.reach = static_cast<float>(0.5 * std::fabs(to - from));
  const double ends = 0.5 * (course.across(first.u, first.v) + course.across(last.u, last.v));
  const double square = double{course.reach} * double{course.reach};
  course.bend = static_cast<float>((ends - course.across(middle.u, middle.v)) / square);
  const double slope = 1 + 2 * std::fabs(double{course.bend}) * double{course.reach};
  if (!(slope < 4)) return std::nullopt;
  const TrimInterval values = places.values_of(course, slope);
  course.low = values.low;
  course.high = values.high;
  return course;
}

// The ranges of pieces in an order.
class OrderRanges {
 public:
  OrderRanges(const TrimCells& cells, const TrimBox& cell, const std::vector<TrimStretch>& chosen)
      : cells_(cells), cell_(cell), chosen_(chosen) {}

  // Leaves the order straight where that is as good. Returns: [chosen].
  std::vector<TrimInterval> of(TrimOrder& order) const {
    std::vector<TrimInterval> straight, bent;
    for (const TrimStretch& seen : chosen_)
      straight.push_back(
          straight_values(seen, piece_of(seen), double{order.n_u}, double{order.n_v}));
    TrimOrder trial = order;
    if (!bend(trial, bent) || !(widths(bent) < widths(straight))) return straight;
    order = trial;
    return bent;
  }

 private:
  const TrimPiece& piece_of(const TrimStretch& seen) const { return cells_.pieces[seen.of.piece]; }
  static double widths(const std::vector<TrimInterval>& ranges) {
    double sum = 0;
    for (const TrimInterval& values : ranges) sum += values.width();
    return sum;
  }

  // As the longest piece bends. Returns: whether all have a range by that.
  bool bend(TrimOrder& order, std::vector<TrimInterval>& ranges) const {
    std::vector<TrimPlaces> of_pieces;
    std::size_t longest = 0;
    double length = 0;
    for (const TrimStretch& seen : chosen_) {
      const auto places = TrimPlaces::of(seen, piece_of(seen), cells_.coefficients.data());
      if (!places.has_value()) return false;
      const double y =
          std::fabs(order.along(seen.high.u, seen.high.v) - order.along(seen.low.u, seen.low.v));
      if (y > length) longest = of_pieces.size();
      length = std::max(length, y);
      of_pieces.push_back(*places);
    }
    if (!(length > 0)) return false;
    fit(order, of_pieces[longest]);
    double y_low = kInf, y_high = -kInf;  // of the cell
    for (const double u : cell_.u)
      for (const double v : cell_.v) {
        y_low = std::min(y_low, order.along(u, v));
        y_high = std::max(y_high, order.along(u, v));
      }
    const double reach = std::max(-y_low, y_high);
    const double slope =
        1 + std::fabs(double{order.tilt}) + 2 * std::fabs(double{order.bend}) * reach;
    if (!(slope < 4)) return false;
    for (const TrimPlaces& places : of_pieces) {
      TrimInterval values = places.values_of(order, slope);
      const double from = order.along(places.first().u, places.first().v);
      const double to = order.along(places.last().u, places.last().v);
      widen(order, std::min(from, to) - y_low, std::min(from, to), -1, values);
      widen(order, y_high - std::max(from, to), std::max(from, to), 1, values);
      ranges.push_back(values);
    }
    return true;
  }

  // Through the ends and the middle of what the cell sees of a piece.
  static void fit(TrimOrder& order, const TrimPlaces& places) {
    const TrimPlace a = places.first(), m = places.middle(), b = places.last();
    order.at = static_cast<float>(order.along(m.u, m.v));
    const double middle = order.across(m.u, m.v);
    const double y0 = order.along(a.u, a.v), x0 = order.across(a.u, a.v) - middle;
    const double y1 = order.along(b.u, b.v), x1 = order.across(b.u, b.v) - middle;
    const double bend = (x1 / y1 - x0 / y0) / (y1 - y0);
    order.bend = static_cast<float>(bend);
    order.tilt = static_cast<float>(x0 / y0 - bend * y0);
  }

  // Takes in what is beside the end y of a piece in the cell, up to `way` from it, y growing or
  // falling by `sign`, by how far beyond the end's value points there may have theirs: as in a
  // straight order (trim_order.h) x itself grows, or falls, with the way from the end, by the
  // smaller of |n_u| and n_v at least.
  static void widen(const TrimOrder& order, double way, double y, double sign,
                    TrimInterval& values) {
    if (!(way > 0)) return;
    const double grows = std::min(std::fabs(double{order.n_u}), double{order.n_v});
    const auto beyond = [&](double side) {  // 1: above the piece, -1: below it
      const double turn = (side * grows * sign - double{order.tilt}) / (2 * double{order.bend});
      double most = 0;
      for (const double gone : {way, sign * (turn - y)}) {
        if (!(gone > 0 && gone <= way)) continue;
        const double taken = order.away(y + sign * gone) - order.away(y);
        most = std::max(most, side * taken - grows * gone);
      }
      return most;
    };
    values = TrimInterval::around(double{values.low} - beyond(1), double{values.high} + beyond(-1));
  }

  const TrimCells& cells_;
  const TrimBox& cell_;
  const std::vector<TrimStretch>& chosen_;
};

}  // namespace

void set_course(const TrimCells& cells, const TrimBox& cell, TrimListed& of) {
  const std::optional<TrimStretch> seen = TrimStretch::of_cell(cells, cell, of);
  if (!seen.has_value()) return;
  const TrimPiece& piece = cells.pieces[of.piece];
  const double du = std::fabs(seen->high.u - seen->low.u), dv = seen->high.v - seen->low.v;
  const double most = std::max(du, dv);
  if (!(most > 0)) return;
  TrimCourse course;
  course.n_u = static_cast<float>((piece.falls != 0 ? dv : -dv) / most);
  course.n_v = static_cast<float>(du / most);
  const TrimInterval straight =
      straight_values(*seen, piece, double{course.n_u}, double{course.n_v});
  std::optional<TrimCourse> parabola;
  if (const auto places = TrimPlaces::of(*seen, piece, cells.coefficients.data()))
    parabola = parabola_of(*places, course);
  course.low = straight.low;
  course.high = straight.high;
  const bool is_nearer = parabola && parabola->high - parabola->low < course.high - course.low;
  of.course = is_nearer ? *parabola : course;
}

std::optional<std::uint32_t> add_order(TrimCells& to, const TrimBox& cell,
                                       const std::vector<TrimListed>& list, std::size_t few) {
  std::vector<TrimStretch> rising, falling;
  std::vector<TrimListed> others;
  for (const TrimListed& of : list) {
    const std::optional<TrimStretch> seen = TrimStretch::of_cell(to, cell, of);
    if (!seen.has_value()) {
      others.push_back(of);
    } else {
      (to.pieces[of.piece].falls != 0 ? falling : rising).push_back(*seen);
    }
  }
  const bool are_rising = rising.size() >= falling.size();
  const std::vector<TrimStretch>& chosen = are_rising ? rising : falling;
  if (chosen.size() <= few) return std::nullopt;
  for (const TrimStretch& seen : are_rising ? falling : rising) others.push_back(seen.of);

  TrimOrder order{};
  double du = 0, dv = 0;
  for (const TrimStretch& seen : chosen) {
    du += std::fabs(seen.high.u - seen.low.u);
    dv += std::max(0.0, seen.high.v - seen.low.v);
  }
  const double most = std::max(du, dv);
  if (!(most > 0)) return std::nullopt;
  order.n_u = static_cast<float>((are_rising ? -dv : dv) / most);
  order.n_v = static_cast<float>(du / most);
  order.first = static_cast<std::uint32_t>(to.listed.size());
  order.ordered = static_cast<std::uint32_t>(chosen.size());
  order.range = static_cast<std::uint32_t>(to.ranges.size());
  std::vector<std::pair<TrimInterval, TrimListed>> sorted;
  const std::vector<TrimInterval> ranges = OrderRanges(to, cell, chosen).of(order);
  for (std::size_t i = 0; i < chosen.size(); ++i) sorted.emplace_back(ranges[i], chosen[i].of);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first.low < b.first.low; });
  float high = -kInf;
  for (const auto& [values, of] : sorted) {
    high = std::max(high, values.high);
    to.ranges.push_back({values.low, high});
    to.listed.push_back(of);
  }
  to.listed.insert(to.listed.end(), others.begin(), others.end());
  to.orders.push_back(order);
  return static_cast<std::uint32_t>(to.orders.size() - 1);
}

}  // namespace tessera::core
