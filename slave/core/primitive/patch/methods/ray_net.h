// SPDX-License-Identifier: Apache-2.0
// A patch as a ray sees it: control points d_ij = (N_0 . X_ij, N_1 . X_ij) with X = w (P - O), the
// distances from two planes that meet in the ray (thesis, 6.6.1). The roots of this net of two
// polynomials are the hits, for rational patches, too, whose weights are positive.
//
// Layout: f[k][(n + 1) i + j] of component k and control point (i, j). Degrees are known when this
// is compiled where they are frequent (NetShape<3, 3>), else NetShape<0, 0> has them.
//
// Threads. Plain values; pure functions.
#pragma once

#include "slave/core/primitive/patch/methods/ray_sight.h"

namespace tessera::core {

template <int kM, int kN>
struct NetShape {
  static constexpr int kPoints = kM != 0 ? (kM + 1) * (kN + 1) : kPatchPointsMax;
  static constexpr int kDegreeU = kM, kDegreeV = kN;
  int at_run_m = kM, at_run_n = kN;

  constexpr int m() const { return kM != 0 ? kM : at_run_m; }
  constexpr int n() const { return kN != 0 ? kN : at_run_n; }
  constexpr int count() const { return (m() + 1) * (n() + 1); }
};

// Calls solve(shape) with the shape of the patch's nets.
template <class Solve>
void by_degrees(const Patch& patch, const Solve& solve) {
  const int m = patch.degree_u, n = patch.degree_v;
  if (m == 3 && n == 3) return solve(NetShape<3, 3>{});
  if (m == 2 && n == 2) return solve(NetShape<2, 2>{});
  if (m == 1 && n == 1) return solve(NetShape<1, 1>{});
  solve(NetShape<0, 0>{m, n});
}

// What is told apart in a net: flat is what |f| is at most within kMethodAccuracy of the ray, noise
// what roundings have made of it, however it is cut (complete_solver.h counts them: below 2^-42 of
// the farthest control point, times its weight).
struct NetScale {
  double flat, noise;
};

template <class Shape>
struct RayNet {
  double f[2][Shape::kPoints];

  NetScale look(const Shape& shape, const Patch& patch, const RaySight& sight) {
    double low_w = std::numeric_limits<double>::infinity(), high_w = 0, far = 0;
    for (int k = 0; k < shape.count(); ++k) {
      const float* const p = patch.numbers + (patch.is_rational ? 4 : 3) * k;
      const Vec3d from{p[0] - sight.origin.x, p[1] - sight.origin.y, p[2] - sight.origin.z};
      const double w = patch.is_rational ? double{p[3]} : 1;
      f[0][k] = w * dot(sight.normal[0], from);
      f[1][k] = w * dot(sight.normal[1], from);
      low_w = std::min(low_w, w);
      high_w = std::max(high_w, w);
      far = std::max(far, dot(from, from));
    }
    const double noise = 0x1p-42 * std::sqrt(far) * high_w;
    return {kMethodAccuracy * patch.extent * low_w + 2 * noise, noise};
  }

  // Whether a component is farther from 0 than `slack` everywhere.
  bool is_elsewhere(const Shape& shape, double slack) const {
    for (const double* net : f) {
      double low = net[0], high = net[0];
      for (int k = 1; k < shape.count(); ++k) {
        low = std::min(low, net[k]);
        high = std::max(high, net[k]);
      }
      if (low > slack || high < -slack) return true;
    }
    return false;
  }
  // Whether all of the net is within `slack` of the ray.
  bool is_within(const Shape& shape, double slack) const {
    for (const double* net : f)
      for (int k = 0; k < shape.count(); ++k)
        if (!(std::fabs(net[k]) <= slack)) return false;
    return true;
  }

  // Keeps [from, to] of [0, 1] of one parameter, 0 for u. What leaves more is cut first: the second
  // share is a quotient, and would be lost near 0.
  void restrict_to(const Shape& shape, int axis, double from, double to) {
    for (double* net : f) {
      if (to >= 1 - from) {
        if (to != 1) cut(shape, net, axis, to, false);
        if (from != 0) cut(shape, net, axis, from / to, true);
      } else {
        cut(shape, net, axis, from, true);
        cut(shape, net, axis, (to - from) / (1 - from), false);
      }
    }
  }

  // Keeps [a, 1] or [0, a] of one component, by de Casteljau's scheme.
  static void cut(const Shape& shape, double* net, int axis, double a, bool keeps_high) {
    const int stride = shape.n() + 1, degree = axis == 0 ? shape.m() : shape.n();
    const int step = axis == 0 ? stride : 1, across = axis == 0 ? 1 : stride;
    const int lines = axis == 0 ? stride : shape.m() + 1;
    const double b = 1 - a;
    for (int k = 1; k <= degree; ++k)
      for (int q = 0; q <= degree - k; ++q) {
        const int to = keeps_high ? q : degree - q, low = keeps_high ? to : to - 1;
        double* const out = net + step * to;
        const double* const in = net + step * low;
        for (int line = 0; line < lines; ++line)
          out[across * line] = b * in[across * line] + a * in[across * line + step];
      }
  }
};

// The part of a parameter's [0, 1] that a sub-patch has, widened by kMethodOverlap.
struct PartSides {
  double low[2], high[2];

  explicit PartSides(const SubPatchRange& range) {
    const double half[2] = {range.half_u * (1 + kMethodOverlap),
                            range.half_v * (1 + kMethodOverlap)};
    const double middle[2] = {range.middle_u, range.middle_v};
    for (int a = 0; a < 2; ++a) {
      low[a] = middle[a] - half[a];
      high[a] = middle[a] + half[a];
    }
  }
};

// A net with the part of the parameters that it is of.
template <class Shape>
struct NetBox : RayNet<Shape> {
  double low[2], high[2];  // of u and v

  // Takes the part of a patch.
  NetScale look_at_part(const Shape& shape, const Patch& patch, const RaySight& sight,
                        const SubPatchRange& range) {
    const NetScale scale = this->look(shape, patch, sight);
    const PartSides sides(range);
    for (int a = 0; a < 2; ++a) {
      low[a] = sides.low[a];
      high[a] = sides.high[a];
      this->restrict_to(shape, a, low[a], high[a]);
    }
    return scale;
  }
  double middle(int axis) const { return 0.5 * (low[axis] + high[axis]); }
  double width(int axis) const { return high[axis] - low[axis]; }
  // Keeps [from, to] of its own [0, 1].
  void keep(const Shape& shape, int axis, double from, double to) {
    this->restrict_to(shape, axis, from, to);
    const double start = low[axis], size = width(axis);
    low[axis] = start + from * size;
    high[axis] = start + to * size;
  }
};

}  // namespace tessera::core
