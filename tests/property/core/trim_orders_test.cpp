// SPDX-License-Identifier: Apache-2.0
// Property: pieces of trimming loops that are put in order within a cell count for its points as
// each does by itself, however they bend, cross and leave the cell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>
#include <optional>
#include <vector>

#include "slave/core/primitive/patch/trim_order.h"
#include "slave/core/primitive/patch/trim_splitting.h"
#include "tests/support/choices.h"

namespace tessera {
namespace {

using core::TrimBox;
using core::TrimCells;
using core::TrimListed;
using core::TrimOrder;
using core::TrimPlace;

constexpr TrimBox kCell{{0.25, 0.75}, {0.25, 0.75}};
constexpr float kInf = std::numeric_limits<float>::infinity();

double between(double low, double high, test::Choices& choices) {
  return low + (high - low) * double{choices.share()};
}
double power_of_two(double low, double high, test::Choices& choices) {
  return std::exp2(between(low, high, choices));
}

// A rational parabola, most often of those that rise, or fall, through the whole cell.
class Curves {
 public:
  Curves(TrimCells& to, test::Choices& choices) : to_(to), choices_(choices) {
    falls_ = choices.below(2) == 1;
    base_ = any();
    spread_ = power_of_two(-8, -2, choices);
  }

  void add() {
    Shape shape = choices_.below(4) == 0 ? any() : base_;
    for (float* const x : {&shape.points[0].u, &shape.points[0].v, &shape.points[2].u,
                           &shape.points[2].v, &shape.points[1].u, &shape.points[1].v})
      *x = static_cast<float>(
          std::clamp(double{*x} + between(-spread_, spread_, choices_), 0.0, 1.0));
    if (falls_)
      for (TrimPoint& point : shape.points) point.u = 1 - point.u;
    const auto first = static_cast<std::uint32_t>(to_.coefficients.size());
    for (int i = 0; i < 3; ++i)
      to_.coefficients.push_back(core::coefficient_of(shape.points[i], 2, i));
    core::split_segment(shape.points, first, to_.pieces);
  }

 private:
  struct Shape {
    TrimPoint points[3];
  };

  // From the left or below to the right or above.
  Shape any() {
    const auto side = [&](double low) {
      double u = double{choices_.share()}, v = double{choices_.share()};
      (choices_.below(2) == 0 ? u : v) = between(low, low + 0.25, choices_);
      return TrimPoint{static_cast<float>(u), static_cast<float>(v), 1};
    };
    Shape shape{{side(0), {}, side(0.75)}};
    const auto inner = [&](float a, float b) {
      return static_cast<float>(between(double{a}, double{b}, choices_));
    };
    shape.points[1] = {inner(shape.points[0].u, shape.points[2].u),
                       inner(shape.points[0].v, shape.points[2].v),
                       static_cast<float>(power_of_two(-5, 5, choices_))};
    return shape;
  }

  TrimCells& to_;
  test::Choices& choices_;
  bool falls_;
  Shape base_;
  double spread_;
};

TrimListed listed(const TrimCells& cells, std::uint32_t number) {
  const core::TrimPiece& piece = cells.pieces[number];
  const double low = double{std::min(piece.u[0], piece.u[1])};
  const double high = double{std::max(piece.u[0], piece.u[1])};
  float edge = piece.falls != 0 ? -kInf : kInf;
  if (low <= kCell.u[1] && kCell.u[1] < high)
    edge = static_cast<float>(core::v_at(piece, cells.coefficients.data(), kCell.u[1]));
  return {number, edge, {}};
}

struct Counts {
  int orders = 0, bent = 0, points = 0, wrong = 0;
};

void judge(test::Choices& choices, Counts& counts) {
  TrimCells cells;
  Curves curves(cells, choices);
  for (unsigned left = 8 + choices.below(24); left > 0; --left) curves.add();
  std::vector<TrimListed> list;
  for (std::uint32_t i = 0; i < cells.pieces.size(); ++i) list.push_back(listed(cells, i));
  const std::optional<std::uint32_t> number = core::add_order(cells, kCell, list, 6);
  if (!number.has_value()) return;
  const TrimOrder& order = cells.orders[*number];
  ++counts.orders;
  counts.bent += order.bend != 0;
  core::TrimCell cell;
  cell.first = *number;
  cell.count = static_cast<std::uint32_t>(list.size()) & 0x1fffffffu;
  cell.is_ordered = 1;
  for (int i = 0; i < 200; ++i) {
    TrimPlace at{between(0.25, 0.75, choices), between(0.25, 0.75, choices)};
    if (i % 2 == 0) {  // close to a side: corners are where pieces are left behind
      const double beside = power_of_two(-16, -2, choices);
      double& x = choices.below(2) == 0 ? at.u : at.v;
      x = choices.below(2) == 0 ? 0.25 + beside : 0.75 - beside;
    }
    const auto is_near = [&](const TrimListed& of) {
      return core::is_near(cells.pieces[of.piece], cells.coefficients.data(), at,
                           {0x1p-21, 0x1p-21});
    };
    if (std::any_of(list.begin(), list.end(), is_near)) continue;
    bool is_odd = false;
    std::uint64_t points = 0;
    for (const TrimListed& of : list) is_odd ^= cells.counts(of, at.u, at.v, points);
    core::TrimSteps steps;
    ++counts.points;
    counts.wrong += cells.is_odd(cell, at.u, at.v, steps) != is_odd;
  }
}

TEST(TrimOrder, PiecesInOrderCountAsEachByItself) {
  const int cells = std::getenv("TESSERA_LONG") == nullptr ? 20000 : 200000;
  test::Choices choices(47);
  Counts counts;
  for (int i = 0; i < cells; ++i) judge(choices, counts);
  std::cout << counts.orders << " orders, " << counts.bent << " of them bent, " << counts.points
            << " points\n";
  EXPECT_EQ(counts.wrong, 0);
  EXPECT_GE(counts.bent, counts.orders / 10);
  EXPECT_GE(counts.points, 100 * cells / 2);
}

}  // namespace
}  // namespace tessera
