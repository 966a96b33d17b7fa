// SPDX-License-Identifier: Apache-2.0
// Property: exact_hit() decides as integer arithmetic does, for rays and triangles on an integer
// grid, most of them degenerate in some way: through vertices and edges, in the plane, flat. So
// does the oracle of the other tests, rational_hit(), and both agree on floats of all sizes.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "slave/core/primitive/triangle/exact_hit_abi.h"
#include "tests/support/choices.h"
#include "tests/support/rational_hit.h"
#include "tests/support/seed.h"

namespace tessera::core {
namespace {

// ISO C++ has no such type; the compilers that build this project do.
__extension__ using Wide = __int128;

struct Point {
  std::int64_t x, y, z;
};

Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

Wide determinant(Point p, Point q, Point r) {
  return Wide{p.x} * (Wide{q.y} * r.z - Wide{q.z} * r.y) +
         Wide{p.y} * (Wide{q.z} * r.x - Wide{q.x} * r.z) +
         Wide{p.z} * (Wide{q.x} * r.y - Wide{q.y} * r.x);
}

int sign(Wide v) { return (v > 0) - (v < 0); }

struct Case {
  Point origin, direction, corner[3];

  bool is_hit() const {
    int sides = 0;  // bit 0: some edge on the left, bit 1: on the right
    for (int c = 0; c < 3; ++c) {
      const int s = sign(determinant(direction, corner[c] - origin, corner[(c + 1) % 3] - origin));
      sides |= s < 0 ? 1 : s > 0 ? 2 : 0;
    }
    return sides == 1 || sides == 2;
  }
  double t() const {
    const Point b = corner[1] - corner[0], c = corner[2] - corner[0];
    return static_cast<double>(determinant(corner[0] - origin, b, c)) /
           static_cast<double>(determinant(direction, b, c));
  }
};

class Generator {
 public:
  explicit Generator(std::uint32_t seed) : random_(test::seed(seed)) {}

  Case next() {
    range_ = 1 << (random_() % 4 == 0 ? 22 : 1 + random_() % 10);
    Case c;
    c.origin = point();
    for (Point& corner : c.corner) corner = point();
    if (random_() % 8 == 0) c.corner[2] = c.corner[0];
    Point target = point();
    switch (random_() % 4) {
      case 0:
        target = c.corner[random_() % 3];
        break;
      case 1:  // a point of an edge, on a grid that is twice as fine as the corners
        for (Point& corner : c.corner) corner = corner + corner;
        target = {(c.corner[0].x + c.corner[1].x) / 2, (c.corner[0].y + c.corner[1].y) / 2,
                  (c.corner[0].z + c.corner[1].z) / 2};
        break;
      case 2:  // in the plane
        target = c.origin + (c.corner[1] - c.corner[0]);
        break;
      default:
        break;
    }
    c.direction = target - c.origin;
    // The ray is moved by one unit of the grid, the nearest that it can pass.
    if (random_() % 4 == 0) c.direction.x += 1;
    if (c.direction.x == 0 && c.direction.y == 0 && c.direction.z == 0) c.direction.z = 1;
    return c;
  }

 private:
  std::int64_t coordinate() {
    return static_cast<std::int64_t>(random_() % static_cast<std::uint32_t>(range_)) - range_ / 2;
  }
  Point point() { return {coordinate(), coordinate(), coordinate()}; }

  std::mt19937 random_;
  int range_ = 2;
};

void put(Point p, float scale, float* to) {
  to[0] = static_cast<float>(p.x) * scale;
  to[1] = static_cast<float>(p.y) * scale;
  to[2] = static_cast<float>(p.z) * scale;
}

TEST(ExactHit, DecidesAsIntegersDo) {
  const std::uint32_t seed = 20061;
  Generator generator(seed);
  // Powers of two change no decision; the smallest makes all coordinates denormal.
  const float scales[] = {1, 0x1p-149f, 0x1p-60f, 0x1p80f};
  std::size_t hits = 0;
  for (int i = 0; i < 400'000; ++i) {
    const Case c = generator.next();
    const float scale = scales[i % 4], direction_scale = scales[i / 4 % 4];
    float origin[3], direction[3], triangle[9];
    put(c.origin, scale, origin);
    put(c.direction, direction_scale, direction);
    for (int k = 0; k < 3; ++k) put(c.corner[k], scale, triangle + 3 * k);
    const ExactHit answer = exact_hit(origin, direction, triangle);
    ASSERT_EQ(answer.is_hit, c.is_hit()) << "seed " << seed << ", case " << i;
    const test::RationalHit rational = test::rational_hit(origin, direction, triangle);
    ASSERT_EQ(rational.is_hit, c.is_hit()) << "seed " << seed << ", case " << i;
    if (!answer.is_hit) continue;
    ++hits;
    const double t = c.t() * (double{scale} / double{direction_scale});
    const float lowest = std::nextafterf(static_cast<float>(t), -INFINITY);
    const float highest = std::nextafterf(static_cast<float>(t), INFINITY);
    ASSERT_TRUE(answer.t >= lowest && answer.t <= highest)
        << "seed " << seed << ", case " << i << ": t " << answer.t << ", not " << t;
  }
  EXPECT_GT(hits, 50'000u);  // the cases are not all misses
}

// A float of any size, of either sign, mostly with few bits, now and then zero.
float any_float(test::Choices& any, int least, int most) {
  if (any.one_in(8)) return 0;
  const float share = any.one_in(2) ? std::round(8 * any.sign()) / 8 : any.sign();
  const auto range = static_cast<unsigned>(most - least);
  return std::ldexp(share, least + static_cast<int>(any.below(range)));
}

TEST(ExactHit, DecidesAsRationalArithmeticDoes) {
  test::Choices any(20062);
  std::size_t hits = 0;
  for (int i = 0; i < 100'000; ++i) {
    // Numbers of one size, of sizes 2^40 apart, or of all sizes that float32 has.
    const int widths[] = {1, 40, 250}, width = widths[any.below(3)];
    const int least = -149 + static_cast<int>(any.below(static_cast<unsigned>(270 - width)));
    float origin[3] = {}, direction[3] = {}, triangle[9] = {};
    for (float& x : triangle) x = any_float(any, least, least + width);
    if (any.one_in(3)) std::copy_n(triangle + 3, any.below(4), triangle + 6);
    for (int a = 0; a < 3; ++a) {
      const float one = any.share(), other = any.share() * (1 - one);
      const float target = triangle[a] + one * (triangle[3 + a] - triangle[a]) +
                           (i % 2 == 0 ? other * (triangle[6 + a] - triangle[a]) : 0);
      origin[a] = any.one_in(4) ? triangle[a] : any_float(any, least, least + width);
      direction[a] = any.one_in(8) ? any_float(any, least, least + width) : target - origin[a];
    }
    if (direction[0] == 0 && direction[1] == 0 && direction[2] == 0) continue;
    const ExactHit answer = exact_hit(origin, direction, triangle);
    const test::RationalHit rational = test::rational_hit(origin, direction, triangle);
    ASSERT_EQ(answer.is_hit, rational.is_hit) << "case " << i;
    if (!answer.is_hit) continue;
    ++hits;
    if (!std::isfinite(answer.t)) continue;  // beyond float32
    ASSERT_TRUE(test::is_near({answer.t, false}, rational.t)) << "case " << i << ": " << answer.t;
  }
  EXPECT_GT(hits, 10'000u);
}

}  // namespace
}  // namespace tessera::core
