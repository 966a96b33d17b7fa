// SPDX-License-Identifier: Apache-2.0
// The control points of a patch of degrees up to 3 as a ray's origin sees them, raised to degree 3,
// and the points and derivatives of a sub-patch of it.
//
// Threads. Pure functions.
#include "slave/core/primitive/patch/patch_layout.h"

#if defined(TESSERA_CORE_CUBIC_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_CUBIC_POINTS_INL_H_
#undef TESSERA_CORE_CUBIC_POINTS_INL_H_
#else
#define TESSERA_CORE_CUBIC_POINTS_INL_H_
#endif

#include "slave/core/primitive/patch/cubic_net-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

struct CubicPoints {
  struct Jet {
    Triple point, du, dv;  // derivatives by x, y
  };

  HWY_INLINE explicit CubicPoints(const SubPatch& part) {
    half[0] = 1.0 / (2u << part.level_u);
    half[1] = 1.0 / (2u << part.level_v);
    middle[0] = (2 * part.column + 1) * half[0];
    middle[1] = (2 * part.row + 1) * half[1];
  }
  HWY_INLINE void load(const Patch& patch, const float* origin);
  HWY_INLINE Jet jet_at(double x, double y) const;

  Quad point[4][4];           // w x, w y, w z, w relative to the origin
  double half[2], middle[2];  // of the sub-patch's range
  bool is_rational = false;
  double far = 0;  // the largest coordinate of a point
  double low_w = 1, high_w = 1;

 private:
  static HWY_INLINE Quad point_less(const Patch& patch, int number, const Quad& origin);
};

// w x, w y, w z less w times the origin, and w.
Quad CubicPoints::point_less(const Patch& patch, int number, const Quad& origin) {
  if (patch.is_rational) {
    const float* const p = patch.numbers + 4 * number;
    const double w = static_cast<double>(p[3]);
    return w * Quad::of_three(p, 1) - w * origin;
  }
  const float* const p = patch.numbers + 3 * number;
  const bool is_last = number + 1 == (patch.degree_u + 1) * (patch.degree_v + 1);
  if (!is_last) return Quad::of_three(p, 1) - origin;
  const float last[4] = {p[0], p[1], p[2], 1};  // nothing is read behind the patch
  return Quad::of_three(last, 1) - origin;
}

// Takes the points relative to the origin, raised to degree 3.
void CubicPoints::load(const Patch& patch, const float* origin) {
  is_rational = patch.is_rational;
  const int m = patch.degree_u, n = patch.degree_v;
  alignas(32)
      const double from[4] = {static_cast<double>(origin[0]), static_cast<double>(origin[1]),
                              static_cast<double>(origin[2]), 0};
  const Quad o = Quad::loaded(from);
  Quad size = Quad::all(0);
  double least_w = __builtin_inf(), most_w = 0;
  for (int i = 0; i <= m; ++i) {
    for (int j = 0; j <= n; ++j) {
      const Quad q = point_less(patch, (n + 1) * i + j, o);
      point[i][j] = q;
      Quad s = max(q, Quad::all(0) - q);
      if (is_rational) {
        const double w = static_cast<double>(patch.numbers[4 * ((n + 1) * i + j) + 3]);
        s = (1 / w) * s;
        least_w = min_of(least_w, w);
        most_w = max_of(most_w, w);
      }
      size = max(size, s);
    }
    for (int k = n + 1; k <= 3; ++k)  // from degree k - 1 to k
      for (int j = k; j >= 0; --j) {
        const double a = static_cast<double>(j) / k;
        point[i][j] = j == k   ? point[i][j - 1]
                      : j == 0 ? point[i][0]
                               : a * point[i][j - 1] + (1 - a) * point[i][j];
      }
  }
  for (int k = m + 1; k <= 3; ++k)
    for (int i = k; i >= 0; --i) {
      const double a = static_cast<double>(i) / k;
      for (int j = 0; j <= 3; ++j)
        point[i][j] = i == k   ? point[i - 1][j]
                      : i == 0 ? point[0][j]
                               : a * point[i - 1][j] + (1 - a) * point[i][j];
    }
  double sizes[4];
  size.store(sizes);
  far = max_of(max_of(sizes[0], sizes[1]), sizes[2]);
  if (is_rational) {
    low_w = least_w;
    high_w = most_w;
  }
}

CubicPoints::Jet CubicPoints::jet_at(double x, double y) const {
  const double at[2] = {middle[0] + half[0] * x, middle[1] + half[1] * y};
  double weight[2][4], slope[2][4];
  for (int a = 0; a < 2; ++a) {
    const double u = at[a], v = 1 - u, uu = u * u, vv = v * v, uv = 2 * (u * v);
    weight[a][0] = vv * v;
    weight[a][1] = 3 * (vv * u);
    weight[a][2] = 3 * (uu * v);
    weight[a][3] = uu * u;
    const double h = 3 * half[a];
    slope[a][0] = -h * vv;
    slope[a][1] = h * (vv - uv);
    slope[a][2] = h * (uv - uu);
    slope[a][3] = h * uu;
  }
  Quad sums[3] = {Quad::all(0), Quad::all(0), Quad::all(0)};
  for (int i = 0; i < 4; ++i) {
    const Quad* const p = point[i];
    const Quad value =
        (weight[1][0] * p[0] + weight[1][1] * p[1]) + (weight[1][2] * p[2] + weight[1][3] * p[3]);
    const Quad across =
        (slope[1][0] * p[0] + slope[1][1] * p[1]) + (slope[1][2] * p[2] + slope[1][3] * p[3]);
    sums[0] = sums[0] + weight[0][i] * value;
    sums[1] = sums[1] + slope[0][i] * value;
    sums[2] = sums[2] + weight[0][i] * across;
  }
  double of[3][4];
  for (int k = 0; k < 3; ++k) sums[k].store(of[k]);
  if (!is_rational)
    return {{of[0][0], of[0][1], of[0][2]},
            {of[1][0], of[1][1], of[1][2]},
            {of[2][0], of[2][1], of[2][2]}};
  const double inverse = 1 / of[0][3];
  const double s[3] = {of[0][0] * inverse, of[0][1] * inverse, of[0][2] * inverse};
  const auto derivative = [&](const double* d) {
    return Triple{(d[0] - s[0] * d[3]) * inverse, (d[1] - s[1] * d[3]) * inverse,
                  (d[2] - s[2] * d[3]) * inverse};
  };
  return {{s[0], s[1], s[2]}, derivative(of[1]), derivative(of[2])};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
