// SPDX-License-Identifier: Apache-2.0
// Rational Bezier curves in the parameter plane of a face, in double.
//
// Units. Parameters of the face, or of one patch. Threads. Plain values.
#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace tessera::import::cad {

struct Point2 {
  double u = 0, v = 0;
  bool operator==(const Point2&) const = default;
};

// A control point and its weight, > 0.
struct Control2 {
  double u = 0, v = 0, weight = 1;
};

struct Curve2 {
  std::vector<Control2> points;  // degree + 1, at least 2
  int edge = -1;                 // the number of the edge that the curve belongs to; -1: of none

  std::size_t degree() const { return points.size() - 1; }
  Point2 first() const { return {points.front().u, points.front().v}; }
  Point2 last() const { return {points.back().u, points.back().v}; }
  // The place at `t` in [0, 1].
  Point2 at(double t) const;
};

// The parts of a curve before and behind `t`; both have the same place there, to the bit.
std::pair<Curve2, Curve2> split(const Curve2& curve, double t);
Curve2 reversed(Curve2 curve);
// The same curve, whose parameter runs otherwise, with weight 1 at both ends: curves of a loop
// share the points where they meet, weights included.
Curve2 with_end_weights_1(Curve2 curve);

// The parameters in (0, 1) where u (is_v: v) passes `value`, or touches it, in rising order.
std::vector<double> crossings(const Curve2& curve, bool is_v, double value);

// Curves that follow `place` over [0, 1] within `tolerance` at the places between the nodes, of
// degree 9 at most. The ends are exact.
std::vector<Curve2> fit(const std::function<Point2(double)>& place, double tolerance);

// Whether an odd number of the curves lies above the point (towards rising v). The curves form
// closed loops.
bool is_enclosed(const std::vector<Curve2>& curves, Point2 point);

}  // namespace tessera::import::cad
