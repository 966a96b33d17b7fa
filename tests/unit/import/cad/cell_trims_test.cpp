// SPDX-License-Identifier: Apache-2.0
// Loops that hug the end of their surface: they are not cut to pieces, and what lies beyond the end
// follows it.
#include "master/import/cad/cell_trims.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tessera::import::cad {
namespace {

Curve2 line(Point2 a, Point2 b, int edge) { return {{{a.u, a.v, 1}, {b.u, b.v, 1}}, edge}; }

// The square [0, 3] x [0, 1] as three patches, whose upper edge, number 0, waves about v = 1.
FaceTrims waving(double height, int waves) {
  std::vector<Curve2> loop = fit(
      [&](double t) {
        return Point2{3 - 3 * t, 1 + height * std::sin(2 * std::numbers::pi * waves * t)};
      },
      1e-12);
  for (Curve2& curve : loop) curve.edge = 0;
  loop.front().points.front() = {3, 1, 1};
  loop.back().points.back() = {0, 1, 1};
  loop.push_back(line({0, 1}, {0, 0}, 1));
  loop.push_back(line({0, 0}, {3, 0}, 2));
  loop.push_back(line({3, 0}, {3, 1}, 3));
  return *share_out({loop}, {{0, 1, 2, 3}, false}, {{0, 1}, false});
}

std::size_t segment_count(const FaceTrims& trims) {
  std::size_t count = 0;
  for (const CellTrims& cell : trims.cells)
    for (const auto& loop : cell.loops) count += loop.size();
  return count;
}

TEST(CellTrims, CurvesThatWaveAboutTheEndAreCutWhereTheyPassIt) {
  for (const double height : {1e-3, 1e-6, 1e-7}) {
    const FaceTrims trims = waving(height, 9);
    EXPECT_LE(segment_count(trims), 60u) << height;  // 9 arcs below, fitted by up to 3, and lines
    EXPECT_EQ(trims.open_count, 0);
    double beyond = 0;
    for (const Overrun& overrun : trims.overruns) {
      EXPECT_EQ(overrun.edge, 0);
      EXPECT_EQ(overrun.border.v, 1);
      EXPECT_EQ(overrun.border.u, overrun.place.u);
      beyond = std::max(beyond, overrun.place.v - 1);
    }
    EXPECT_NEAR(beyond, height, 0.02 * height);
    for (const CellTrims& cell : trims.cells) {
      EXPECT_TRUE(cell.is_kept);
      for (const auto& loop : cell.loops)
        for (const Curve2& curve : loop)
          for (const Control2& p : curve.points) EXPECT_TRUE(p.v >= 0 && p.v <= 1) << p.v;
    }
  }
}

TEST(CellTrims, WhatLiesWithinARoundingOfTheEndLiesOnIt) {
  const FaceTrims trims = waving(1e-9, 9);
  EXPECT_EQ(segment_count(trims), 0u);
  EXPECT_TRUE(trims.overruns.empty());
}

TEST(CellTrims, LoopsThatCrossBordersWithoutEndAreRefused) {
  // 2,000 patches in a row, crossed by 52 lines from end to end: 104,000 pieces.
  Axis row;
  for (int i = 0; i <= 2000; ++i) row.borders.push_back(i);
  std::vector<Curve2> loop;
  for (int i = 0; i < 52; ++i) {
    const double v = (i + 0.5) / 54, next = (i + 1.5) / 54;
    const double from = i % 2 == 0 ? 0.5 : 1999.5, to = 2000 - from;
    loop.push_back(line({from, v}, {to, v}, 0));
    loop.push_back(line({to, v}, {to, next}, 0));
  }
  loop.push_back(line(loop.back().last(), loop.front().first(), 0));
  const auto trims = share_out({loop}, row, {{0, 1}, false});
  ASSERT_FALSE(trims.is_ok());
  EXPECT_EQ(trims.status().message(), "its loops cross the borders of patches too often");
}

TEST(CellTrims, EndWeightsOf1LeaveTheCurve) {
  const Curve2 given{{{0, 0, 0.5}, {1, 0, 2}, {1, 1, 3}, {0, 1, 4}}, 7};
  const Curve2 made = with_end_weights_1(given);
  EXPECT_EQ(made.edge, 7);
  EXPECT_EQ(made.points.front().weight, 1);
  EXPECT_EQ(made.points.back().weight, 1);
  const double c = std::cbrt(0.5 / 4);
  for (const double t : {0.1, 0.3, 0.5, 0.8}) {
    // The parameter of the same place.
    const Point2 a = made.at(t), b = given.at(c * t / (1 - t + c * t));
    EXPECT_NEAR(a.u, b.u, 1e-14);
    EXPECT_NEAR(a.v, b.v, 1e-14);
  }
}

}  // namespace
}  // namespace tessera::import::cad
