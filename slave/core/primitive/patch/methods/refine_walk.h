// SPDX-License-Identifier: Apache-2.0
// Uniform refinement (C. Benthin, I. Wald, P. Slusallek, "Interactive ray tracing of free-form
// surfaces", AFRIGRAPH 2004; thesis, 6.3): the net is halved, by u and by v in turns, down to a
// level that is the same for all, so that neighbours fit; halves whose signs show that they are
// beside the ray are dropped; what is left at the end is a facet.
//
// A facet's test is a type, with
//   static void test(const FacetCorners&, Found&&): calls found(s, t) for each hit of the facet at
//   s, t in [0, 1].
//
// Error. A bilinear facet of a polynomial patch of degrees m, n is off by h_u^2 / 8 |S_uu| +
// h_v^2 / 8 |S_vv| at most, and |S_uu| <= 2 m (m - 1) of the patch's size (facet_error()).
//
// Threads. Pure functions.
#pragma once

#include "slave/core/primitive/patch/methods/method_limits.h"
#include "slave/core/primitive/patch/methods/ray_net.h"

namespace tessera::core {

struct RefineHow {
  int level_u = 8, level_v = 8;  // halvings of the whole patch, at most kMethodRefinementMax
};

// What facets of a patch are off by at most, where it is polynomial, in the scene's units. Weights
// that differ by a factor rho count with its square, which measurements confirm.
inline double facet_error(const RefineHow& how, const Patch& patch) {
  double low = 1, high = 1;
  for (int k = 0; patch.is_rational && k < (patch.degree_u + 1) * (patch.degree_v + 1); ++k) {
    const double w = double{patch.numbers[4 * k + 3]};
    low = k == 0 ? w : std::min(low, w);
    high = k == 0 ? w : std::max(high, w);
  }
  const auto of_side = [](int degree, int level) {
    return std::ldexp(0.25 * degree * (degree - (degree > 1 ? 1 : 0)), -2 * level);
  };
  const double polynomial =
      of_side(patch.degree_u, how.level_u) + of_side(patch.degree_v, how.level_v);
  return polynomial * patch.extent * (high / low) * (high / low);
}

// Where the corners of a facet are, seen along the ray: [corner][plane]; corner 2 i + j is at u =
// i, v = j.
struct FacetCorners {
  double at[4][2];
};

// How far beyond [0, 1] a facet is hit, for roundings.
inline constexpr double kFacetEdge = 0x1p-30;

// Bilinear facets: S00 + s A + t B + s t C = 0 (S. Ramsey, K. Potter, C. Hansen, "Ray bilinear
// patch intersections", Journal of Graphics Tools 9, 2004).
struct BilinearFacet {
  template <class Found>
  static void test(const FacetCorners& corners, const Found& found) {
    const auto& p = corners.at;
    double a[2], b[2], c[2];
    for (int k = 0; k < 2; ++k) {
      a[k] = p[2][k] - p[0][k];
      b[k] = p[1][k] - p[0][k];
      c[k] = p[3][k] - p[2][k] - b[k];
    }
    const auto cross = [](const double* x, const double* y) { return x[0] * y[1] - x[1] * y[0]; };
    const double q2 = cross(a, c), q1 = cross(p[0], c) + cross(a, b), q0 = cross(p[0], b);
    const double square = q1 * q1 - 4 * q2 * q0;
    if (!(square >= 0)) return;
    const double q = -0.5 * (q1 + std::copysign(std::sqrt(square), q1));
    const double roots[2] = {q / q2, q0 / q};
    for (int r = 0; r < 2; ++r) {
      const double s = roots[r];
      if (!(s >= -kFacetEdge && s <= 1 + kFacetEdge) || (r == 1 && s == roots[0])) continue;
      const double x = b[0] + s * c[0], y = b[1] + s * c[1];
      const double t = -((p[0][0] + s * a[0]) * x + (p[0][1] + s * a[1]) * y) / (x * x + y * y);
      if (t >= -kFacetEdge && t <= 1 + kFacetEdge) found(s, t);
    }
  }
};

template <class Shape, class Facet>
class Refinement {
 public:
  Refinement(const RefineHow& how, const Shape& shape, const Patch& patch, const SubPatch& part,
             NearestRoot& to)
      : how_(how), shape_(shape), patch_(patch), part_(part), to_(to) {}

  void run(const RaySight& sight) {
    Node& first = stack_[0];
    look(sight, first);
    first.column = part_.column;
    first.row = part_.row;
    first.level_u = part_.level_u;
    first.level_v = part_.level_v;
    for (int axis = 0; axis < 2; ++axis) {
      const double size = std::ldexp(1.0, -(axis == 0 ? part_.level_u : part_.level_v));
      const double from = (axis == 0 ? part_.column : part_.row) * size;
      for (int c = 0; c < kComponents; c += 2)
        first.pair(c).restrict_to(shape_, axis, from, from + size);
    }
    depth_ = 1;
    while (depth_ > 0) step();
  }

 private:
  // Distances from two planes, and t w and w, from which t comes.
  static constexpr int kComponents = 4;
  struct Node {
    RayNet<Shape> pairs[kComponents / 2];
    unsigned column, row;
    int level_u, level_v;
    RayNet<Shape>& pair(int component) { return pairs[component / 2]; }
    double* net(int component) { return pairs[component / 2].f[component % 2]; }
    const double* net(int component) const { return pairs[component / 2].f[component % 2]; }
  };

  void look(const RaySight& sight, Node& node) {
    noise_ = node.pairs[0].look(shape_, patch_, sight).noise;
    for (int k = 0; k < shape_.count(); ++k) {
      const float* const p = patch_.numbers + (patch_.is_rational ? 4 : 3) * k;
      const double w = patch_.is_rational ? double{p[3]} : 1;
      const Vec3d from{p[0] - sight.origin.x, p[1] - sight.origin.y, p[2] - sight.origin.z};
      node.net(2)[k] = w * sight.depth(from);
      node.net(3)[k] = w;
    }
  }

  // Looks at the last node, which ends or has its halves in its place.
  void step() {
    Node& node = stack_[depth_ - 1];
    if (node.pairs[0].is_elsewhere(shape_, noise_)) {
      --depth_;
      return;
    }
    const int left[2] = {how_.level_u - node.level_u, how_.level_v - node.level_v};
    if (left[0] <= 0 && left[1] <= 0) return end(node);
    const int axis = left[0] >= left[1] ? 0 : 1;
    Node& low = stack_[depth_++];
    low = node;
    for (int c = 0; c < (patch_.is_rational ? 4 : 3); ++c) {
      RayNet<Shape>::cut(shape_, low.net(c), axis, 0.5, false);
      RayNet<Shape>::cut(shape_, node.net(c), axis, 0.5, true);
    }
    const auto number = [axis](Node& of, unsigned upper) {
      unsigned& place = axis == 0 ? of.column : of.row;
      place = 2 * place + upper;
      ++(axis == 0 ? of.level_u : of.level_v);
    };
    number(low, 0);
    number(node, 1);
  }

  void end(const Node& node) {
    --depth_;
    const int last = shape_.count() - 1, n = shape_.n();
    const int corner[4] = {0, n, last - n, last};
    FacetCorners corners;
    double depth[4];
    for (int c = 0; c < 4; ++c) {
      const double w = patch_.is_rational ? node.net(3)[corner[c]] : 1;
      for (int k = 0; k < 2; ++k) corners.at[c][k] = node.net(k)[corner[c]] / w;
      depth[c] = node.net(2)[corner[c]] / w;
    }
    Facet::test(corners, [&](double s, double t) {
      const double at =
          (1 - s) * ((1 - t) * depth[0] + t * depth[1]) + s * ((1 - t) * depth[2] + t * depth[3]);
      to_.add(at, std::ldexp(node.column + std::clamp(s, 0.0, 1.0), -node.level_u),
              std::ldexp(node.row + std::clamp(t, 0.0, 1.0), -node.level_v));
    });
  }

  const RefineHow& how_;
  const Shape shape_;
  const Patch& patch_;
  const SubPatch& part_;
  NearestRoot& to_;
  double noise_ = 0;
  int depth_ = 0;
  Node stack_[2 * kMethodRefinementMax + 1];
};

template <class Facet>
void refined_roots(const RefineHow& how, const Patch& patch, const SubPatch& part,
                   const RaySight& sight, NearestRoot& to) {
  by_degrees(patch, [&]<class Shape>(const Shape& shape) {
    Refinement<Shape, Facet>(how, shape, patch, part, to).run(sight);
  });
}

}  // namespace tessera::core
