// SPDX-License-Identifier: Apache-2.0
// Points and derivatives of the net that a ray sees, and a step of Newton's iteration on it.
// Threads. Pure functions.
#pragma once

#include "slave/core/primitive/patch/methods/method_limits.h"
#include "slave/core/primitive/patch/methods/ray_net.h"

namespace tessera::core {

// Of the net's two components: value, and derivatives by u and v.
struct NetJet {
  double f[2], fu[2], fv[2];

  double size() const { return std::max(std::fabs(f[0]), std::fabs(f[1])); }
};

// Requires: u and v are the net's own, near [0, 1].
template <class Shape>
NetJet jet_of(const Shape& shape, const RayNet<Shape>& net, double u, double v) {
  constexpr int kSide =
      Shape::kDegreeU != 0 ? std::max(Shape::kDegreeU, Shape::kDegreeV) + 1 : kPatchDegreeMax + 1;
  double bu[kSide], su[kSide], bv[kSide], sv[kSide];
  plain::bernstein(shape.m(), u, bu, su);
  plain::bernstein(shape.n(), v, bv, sv);
  NetJet jet{};
  for (int k = 0; k < 2; ++k) {
    const double* row = net.f[k];
    for (int i = 0; i <= shape.m(); ++i, row += shape.n() + 1) {
      double value = 0, slope = 0;
      for (int j = 0; j <= shape.n(); ++j) {
        value += bv[j] * row[j];
        slope += sv[j] * row[j];
      }
      jet.f[k] += bu[i] * value;
      jet.fu[k] += su[i] * value;
      jet.fv[k] += bu[i] * slope;
    }
  }
  return jet;
}

// Returns: whether there is a step to a zero of the plane that touches there.
inline bool newton_step(const NetJet& jet, double (&by)[2]) {
  const double determinant = jet.fu[0] * jet.fv[1] - jet.fv[0] * jet.fu[1];
  if (!(std::fabs(determinant) > 0)) return false;
  by[0] = (jet.fv[0] * jet.f[1] - jet.fv[1] * jet.f[0]) / determinant;
  by[1] = (jet.fu[1] * jet.f[0] - jet.fu[0] * jet.f[1]) / determinant;
  return true;
}

}  // namespace tessera::core
