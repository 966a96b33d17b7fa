// SPDX-License-Identifier: Apache-2.0
// Polygons are covered by their triangles once, whatever their shape.
#include "common/scene_io/polygon.h"
#include "tests/support/seed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tessera {
namespace {

// Twice the signed area, seen along +z.
double area(const std::vector<Vec3f>& p, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return (double{p[b].x} - double{p[a].x}) * (double{p[c].y} - double{p[a].y}) -
         (double{p[b].y} - double{p[a].y}) * (double{p[c].x} - double{p[a].x});
}
double area(const std::vector<Vec3f>& p) {
  double sum = 0;
  for (std::uint32_t i = 2; i < p.size(); ++i) sum += area(p, 0, i - 1, i);
  return sum;
}

// Triangles that all turn as the polygon does and whose areas add up to its own cover it once.
// Areas are sums of products of floats in doubles: 2^-53 each, of terms below `size` squared.
void expect_covered(const std::vector<Vec3f>& p, PolygonCutter& cutter, double size) {
  const auto triangles = cutter.cut(p);
  ASSERT_EQ(triangles.size(), p.size() - 2);
  const double slack = 8 * 0x1p-53 * size * size * static_cast<double>(p.size());
  double sum = 0;
  for (const auto& [a, b, c] : triangles) {
    EXPECT_GE(area(p, a, b, c), -slack);
    sum += area(p, a, b, c);
  }
  EXPECT_NEAR(sum, area(p), slack);
}

TEST(PolygonCutter, ConvexAndNearlyFlatCornersAreFans) {
  EXPECT_TRUE(
      PolygonCutter::is_fan(std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_TRUE(PolygonCutter::is_fan(
      std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}))
      << "a corner on an edge";
  EXPECT_TRUE(PolygonCutter::is_fan(
      std::vector<Vec3f>{{1000, 0, 0}, {1001, 1e-5f, 0}, {1002, 0, 0}, {1002, 1, 0}, {1000, 1, 0}}))
      << "stands inward by less than a coordinate is rounded";
  EXPECT_TRUE(
      PolygonCutter::is_fan(std::vector<Vec3f>{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}));
  EXPECT_FALSE(
      PolygonCutter::is_fan(std::vector<Vec3f>{{0, 0, 0}, {2, 0, 0}, {0.5f, 0.5f, 0}, {0, 2, 0}}) &&
      PolygonCutter::is_fan(std::vector<Vec3f>{{2, 0, 0}, {0.5f, 0.5f, 0}, {0, 2, 0}, {0, 0, 0}}))
      << "an arrowhead is no fan of a barb";
}

TEST(PolygonCutter, StarsOfRandomRadiusAreCoveredInEveryPlane) {
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(test::seed(seed));
    std::uniform_real_distribution<float> radius(0.1f, 1);
    const std::uint32_t count = 4 + static_cast<std::uint32_t>(random() % 60);
    std::vector<Vec3f> star;
    for (std::uint32_t i = 0; i < count; ++i) {
      const float angle = 6.2831853f * static_cast<float>(i) / static_cast<float>(count);
      const float r = radius(random);
      star.push_back({r * std::cos(angle), r * std::sin(angle), 0});
    }
    PolygonCutter cutter;
    expect_covered(star, cutter, 2);
    EXPECT_FALSE(cutter.is_guessed());
    const std::vector flat(cutter.cut(star).begin(), cutter.cut(star).end());
    // In other planes, seen from either side, the star is cut into the same triangles.
    for (const auto& turn : {+[](Vec3f p) {
                               return Vec3f{0, p.x, p.y};
                             },
                             +[](Vec3f p) {
                               return Vec3f{p.y, 0, p.x};
                             }}) {
      std::vector<Vec3f> turned;
      for (const Vec3f& p : star) turned.push_back(turn(p));
      const auto triangles = cutter.cut(turned);
      EXPECT_TRUE(std::equal(triangles.begin(), triangles.end(), flat.begin(), flat.end()));
    }
  }
}

TEST(PolygonCutter, CombsAndHolesCutOpenAreCovered) {
  std::vector<Vec3f> comb{{0, -1, 0}, {40, -1, 0}};
  for (int i = 40; i >= 0; --i) comb.push_back({static_cast<float>(i), i % 2 ? 3.0f : 0.1f, 0});
  PolygonCutter cutter;
  expect_covered(comb, cutter, 40);
  EXPECT_FALSE(cutter.is_guessed());
  // A square with a square hole, joined by an edge there and back.
  const std::vector<Vec3f> frame{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                                 {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  expect_covered(frame, cutter, 4);
  EXPECT_FALSE(cutter.is_guessed());
}

TEST(PolygonCutter, WhatCrossesItselfOrHasNoAreaIsCutAllTheSameAndSaid) {
  PolygonCutter cutter;
  const std::vector<Vec3f> bow{{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 3, 0}};
  EXPECT_FALSE(PolygonCutter::is_fan(bow));
  EXPECT_EQ(cutter.cut(bow).size(), 2u);
  EXPECT_TRUE(cutter.is_guessed());
  const std::vector<Vec3f> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 0, 0}, {0.5f, 0, 0}};
  EXPECT_EQ(cutter.cut(line).size(), 3u);
  EXPECT_TRUE(cutter.is_guessed());
}

}  // namespace
}  // namespace tessera
