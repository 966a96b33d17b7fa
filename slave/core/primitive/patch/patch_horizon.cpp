// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/patch_horizon.h"

#include <algorithm>
#include <cmath>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/fat_border.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/sub_patch_range.h"

namespace tessera::core {
namespace {

// Of the largest coefficient, what second differences may be off by: they have some 2^6 roundings
// of double, and the point, u, v and the normal are rounded to float32, which tilts the plane.
constexpr double kBendError = 0x1p-20;

// Control values of a cubic.
template <class T>
struct Cubic {
  T c[4] = {};
};

template <class T>
T between(T a, T b, double t) {
  return (1 - t) * a + t * b;
}

// The value of the polar form: the curve's own where all three are the same.
template <class T>
T polar(const Cubic<T>& p, double r, double s, double t) {
  const T a = between(p.c[0], p.c[1], r), b = between(p.c[1], p.c[2], r),
          c = between(p.c[2], p.c[3], r);
  return between(between(a, b, s), between(b, c, s), t);
}

template <class T>
Cubic<T> restricted(const Cubic<T>& p, double low, double high) {
  return {{polar(p, low, low, low), polar(p, low, low, high), polar(p, low, high, high),
           polar(p, high, high, high)}};
}

// Raises the degree to 3.
template <class T>
void raise(Cubic<T>& p, int degree) {
  for (int m = degree + 1; m <= 3; ++m)
    for (int i = m; i >= 0; --i) {
      const double share = static_cast<double>(i) / m;
      p.c[i] = i == 0 ? p.c[0] : i == m ? p.c[m - 1] : between(p.c[i], p.c[i - 1], share);
    }
}

// The net of q with p(x) - p(t) = (x - t) q(x), a quadratic.
template <class T>
struct Quotient {
  T c[3];

  Quotient(const Cubic<T>& p, double t) {
    const T d[3] = {p.c[1] - p.c[0], p.c[2] - p.c[1], p.c[3] - p.c[2]};
    const T low = between(d[0], d[1], t), high = between(d[1], d[2], t);
    const T at_t = between(low, high, t);
    c[0] = d[0] + low + at_t;
    c[1] = d[1] + 0.5 * (low + high) + at_t;
    c[2] = d[2] + high + at_t;
  }
};

// The same of a quadratic q: the net of r with q(x) - q(t) = (x - t) r(x), and q(t).
struct SecondQuotient {
  double c[2], at_t;

  SecondQuotient(const Quotient<double>& q, double t) {
    const double d[2] = {q.c[1] - q.c[0], q.c[2] - q.c[1]}, middle = between(d[0], d[1], t);
    c[0] = d[0] + middle;
    c[1] = d[1] + middle;
    at_t = between(between(q.c[0], q.c[1], t), between(q.c[1], q.c[2], t), t);
  }
};

// G over a sub-patch: [i] is by x, of each the cubic by y.
struct Numerators {
  Cubic<Vec3d> by_y[4];

  Cubic<Vec3d> by_x(int j) const {
    return {{by_y[0].c[j], by_y[1].c[j], by_y[2].c[j], by_y[3].c[j]}};
  }
  void set_by_x(int j, const Cubic<Vec3d>& p) {
    for (int i = 0; i < 4; ++i) by_y[i].c[j] = p.c[i];
  }
  // The same with x and y exchanged.
  Numerators exchanged() const { return {{by_x(0), by_x(1), by_x(2), by_x(3)}}; }
};

Numerators numerators_of(const Patch& patch, const SubPatch& part, Vec3d point,
                         const SubPatchRange& range) {
  Numerators g;
  const int m = patch.degree_u, n = patch.degree_v;
  for (int i = 0; i <= m; ++i) {
    for (int j = 0; j <= n; ++j) {
      const PatchPoint p = plain::point_of(patch, (n + 1) * i + j);
      g.by_y[i].c[j] = Vec3d{p.x[0], p.x[1], p.x[2]} - p.x[3] * point;
    }
    raise(g.by_y[i], n);
    if (part.level_v > 0)
      g.by_y[i] =
          restricted(g.by_y[i], range.middle_v - range.half_v, range.middle_v + range.half_v);
  }
  for (int j = 0; j < 4; ++j) {
    Cubic<Vec3d> p = g.by_x(j);
    raise(p, m);
    if (part.level_u > 0)
      p = restricted(p, range.middle_u - range.half_u, range.middle_u + range.half_u);
    g.set_by_x(j, p);
  }
  return g;
}

// Whether the sub-patch lies below its tangent plane. Requires: heights above it.
bool is_below_plane(const Cubic<double> (&height_by_x)[4], double x0, double y0) {
  double alpha = -INFINITY, gamma = -INFINITY, beta = 0, size = 0;
  Cubic<double> at_x0, slope_at_x0;
  for (int j = 0; j < 4; ++j) {
    for (const double h : height_by_x[j].c) size = std::max(size, std::fabs(h));
    at_x0.c[j] = polar(height_by_x[j], x0, x0, x0);
    const SecondQuotient r(Quotient<double>(height_by_x[j], x0), x0);
    alpha = std::max({alpha, r.c[0], r.c[1]});
    slope_at_x0.c[j] = r.at_t;
  }
  const Quotient<double> across(slope_at_x0, y0);
  for (const double b : across.c) beta = std::max(beta, std::fabs(b));
  const SecondQuotient r(Quotient<double>(at_x0, y0), y0);
  gamma = std::max(r.c[0], r.c[1]);
  const double error = kBendError * size;
  return alpha < -error && gamma < -error &&
         (beta + error) * (beta + error) < 4 * (alpha + error) * (gamma + error);
}

// The sine of the widest angle between the normal, or its opposite, and a_ij x b_k; 1 where it is
// no acute one.
double widest_sine(const Numerators& g, double x0, double y0, Vec3d normal) {
  Cubic<Vec3d> at_x0;
  Vec3d a[4][3];
  for (int j = 0; j < 4; ++j) {
    const Cubic<Vec3d> p = g.by_x(j);
    at_x0.c[j] = polar(p, x0, x0, x0);
    const Quotient<Vec3d> q(p, x0);
    std::copy_n(q.c, 3, a[j]);
  }
  const Quotient<Vec3d> b(at_x0, y0);
  const double side = dot(cross(a[0][0], b.c[0]), normal);
  double least = 1;  // of the cosine's square
  for (const auto& row : a)
    for (const Vec3d along_x : row)
      for (const Vec3d along_y : b.c) {
        const Vec3d across = cross(along_x, along_y);
        const double up = dot(across, normal);
        if (!(up * side > 0)) return 1;
        least = std::min(least, up * up / dot(across, across));
      }
  return std::sqrt(std::max(1 - least, 0.0));
}

}  // namespace

std::optional<float> horizon_at(const Patch& patch, const SubPatch& part, float u, float v,
                                Vec3f point, Vec3f normal) {
  if (patch.degree_u > kHorizonDegreeMax || patch.degree_v > kHorizonDegreeMax) return {};
  if (!part.has_frame || is_fat_border(part)) return {};
  const SubPatchRange range(part);
  const Numerators g = numerators_of(patch, part, widened(point), range);
  const auto within = [](double at, double middle, double half) {
    return std::clamp((at - middle) / (2 * half) + 0.5, 0.0, 1.0);
  };
  const double x0 = within(double{u}, range.middle_u, range.half_u);
  const double y0 = within(double{v}, range.middle_v, range.half_v);
  const Vec3d up = widened(normal);
  Cubic<double> height_by_x[4];
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) height_by_x[j].c[i] = dot(up, g.by_y[i].c[j]);
  if (is_below_plane(height_by_x, x0, y0)) return kHorizonRoom;
  // Differences may be taken by x first, or by y; one of both may say more.
  const double sine = std::min(widest_sine(g, x0, y0, up), widest_sine(g.exchanged(), y0, x0, up));
  if (sine >= 1) return {};
  return static_cast<float>(sine) + kHorizonRoom;
}

}  // namespace tessera::core
