// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/patch_evaluation.h"

namespace tessera::core {
namespace {

// Bernstein polynomials of the degree and two of their derivatives.
struct Basis {
  double value[kPatchDegreeMax + 1] = {}, slope[kPatchDegreeMax + 1] = {},
                                 bend[kPatchDegreeMax + 1] = {};

  Basis(int degree, double x) {
    plain::bernstein(degree, x, value, slope);
    if (degree < 2) return;
    // B'' of degree d is d (d - 1) times the second difference of B of degree d - 2; B' of degree
    // d - 1 holds the first differences.
    double lower[kPatchDegreeMax + 1] = {}, first[kPatchDegreeMax + 1] = {};
    plain::bernstein(degree - 1, x, lower, first);
    for (int i = 0; i <= degree; ++i)
      bend[i] = degree * ((i > 0 ? first[i - 1] : 0) - (i < degree ? first[i] : 0));
  }
};

}  // namespace

void take_points(const Patch& patch, PatchPoint* points) {
  const int count = (patch.degree_u + 1) * (patch.degree_v + 1);
  for (int k = 0; k < count; ++k) points[k] = plain::point_of(patch, k);
}

PatchJet evaluate(const Patch& patch, double u, double v) {
  PatchPoint points[kPatchPointsMax];
  take_points(patch, points);
  return evaluate(patch, points, u, v);
}

PatchJet evaluate(const Patch& patch, const PatchPoint* points, double u, double v) {
  const int m = patch.degree_u, n = patch.degree_v;
  if (patch.is_rational) {
    if (m == 2 && n == 2) return plain::evaluated<double, true, 2, 2>(points, 2, 2, u, v);
    if (m == 2 && n == 1) return plain::evaluated<double, true, 2, 1>(points, 2, 1, u, v);
    return plain::evaluated<double, true, 0, 0>(points, m, n, u, v);
  }
  if (m == 3 && n == 3) return plain::evaluated<double, false, 3, 3>(points, 3, 3, u, v);
  if (m == 1 && n == 1) return plain::evaluated<double, false, 1, 1>(points, 1, 1, u, v);
  return plain::evaluated<double, false, 0, 0>(points, m, n, u, v);
}

PatchCurvature second_derivatives(const Patch& patch, double u, double v) {
  const int m = patch.degree_u, n = patch.degree_v;
  const Basis by_u(m, u), by_v(n, v);
  double uu[4] = {}, uv[4] = {}, vv[4] = {};
  PatchPoint points[kPatchPointsMax];
  take_points(patch, points);
  for (int i = 0; i <= m; ++i)
    for (int j = 0; j <= n; ++j)
      for (int a = 0; a < 4; ++a) {
        const double x = points[(n + 1) * i + j].x[a];
        uu[a] += by_u.bend[i] * by_v.value[j] * x;
        uv[a] += by_u.slope[i] * by_v.slope[j] * x;
        vv[a] += by_u.value[i] * by_v.bend[j] * x;
      }
  // With X = w S: X_uv = w_uv S + w_u S_v + w_v S_u + w S_uv. Without weights w is 1.
  const auto sums =
      plain::net_sums<double, 4, 0, 0>(static_cast<const PatchPoint*>(points), m, n, u, v);
  const PatchJet jet = evaluate(patch, points, u, v);
  const double w = sums.of[0][3], wu = sums.of[1][3], wv = sums.of[2][3];
  PatchCurvature out{};
  for (int a = 0; a < 3; ++a) {
    out.duu[a] = (uu[a] - 2 * wu * jet.du[a] - uu[3] * jet.point[a]) / w;
    out.duv[a] = (uv[a] - wu * jet.dv[a] - wv * jet.du[a] - uv[3] * jet.point[a]) / w;
    out.dvv[a] = (vv[a] - 2 * wv * jet.dv[a] - vv[3] * jet.point[a]) / w;
  }
  return out;
}

}  // namespace tessera::core
