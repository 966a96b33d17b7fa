// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/segment_bend.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/sub_patch_bounds.h"

namespace tessera::core {
namespace {

// By which a box is larger than the control points, on each side: more than roundings of where it
// is cut. So no box is without width.
constexpr double kBeside = 0x1p-21;

// Where a coordinate of a part of a curve lies, and bounds of its derivatives by the part's own
// parameter, in which it has length 1.
struct Course {
  double low, high, speed, bend;

  Course(const TrimPart& part, int degree, double TrimCoefficient::*coordinate) {
    double x[kTrimDegreeMax + 1];
    for (int i = 0; i <= degree; ++i) x[i] = part.net[i].*coordinate / part.net[i].w;
    low = *std::min_element(x, x + degree + 1);
    high = *std::max_element(x, x + degree + 1);
    const double middle = 0.5 * (low + high), reach = 0.5 * (high - low);
    double w_least = std::numeric_limits<double>::infinity();
    double a[kTrimDegreeMax + 1];
    for (int i = 0; i <= degree; ++i) {
      w_least = std::min(w_least, part.net[i].w);
      a[i] = part.net[i].w * (x[i] - middle);
    }
    double a1 = 0, a2 = 0, w1 = 0, w2 = 0;
    const auto w = [&](int i) { return part.net[i].w; };
    for (int i = 0; i < degree; ++i) {
      a1 = std::max(a1, std::fabs(a[i + 1] - a[i]));
      w1 = std::max(w1, std::fabs(w(i + 1) - w(i)));
    }
    for (int i = 0; i + 1 < degree; ++i) {
      a2 = std::max(a2, std::fabs((a[i + 2] - a[i + 1]) - (a[i + 1] - a[i])));
      w2 = std::max(w2, std::fabs((w(i + 2) - w(i + 1)) - (w(i + 1) - w(i))));
    }
    const double n = degree;
    // Each has some 2^7 roundings of 2^-53.
    constexpr double kRoom = 1 + 0x1p-40;
    speed = n * (a1 + w1 * reach) / w_least * kRoom;
    bend = (n * (n - 1) * (a2 + w2 * reach) + 2 * n * w1 * speed) / w_least * kRoom;
  }
};

struct Side {
  double low, high;

  explicit Side(const Course& course)
      : low(std::max(course.low - kBeside, 0.0)), high(std::min(course.high + kBeside, 1.0)) {}
  double middle() const { return 0.5 * (low + high); }
  double half() const { return 0.5 * (high - low); }
};

}  // namespace

SegmentBend::SegmentBend(const Patch& patch) : patch_(patch) {
  take_points(patch, points_);
  for (PatchNet* net : {&x_[0], &x_[1], &x_[2], &w_}) *net = net_of(patch.degree_u, patch.degree_v);
  const PatchJet middle = evaluate(patch, points_, 0.5, 0.5);
  double from[3];
  for (int a = 0; a < 3; ++a) from[a] = static_cast<float>(middle.point[a]);
  for (int i = 0; i <= w_.m; ++i)
    for (int j = 0; j <= w_.n; ++j) {
      const PatchPoint& p = points_[(w_.n + 1) * i + j];
      w_.c[i][j] = p.x[3];
      // In units of the patch's extent, so that bounds do not depend on it.
      for (int a = 0; a < 3; ++a) x_[a].c[i][j] = (p.x[a] - from[a] * p.x[3]) / patch.extent;
    }
}

double SegmentBend::away_from_chord(const TrimPart& part, int degree) const {
  const Course u(part, degree, &TrimCoefficient::u), v(part, degree, &TrimCoefficient::v);
  const Side side_u(u), side_v(v);
  PatchNet x[3] = {x_[0], x_[1], x_[2]}, w = w_;
  // Of each net 60 steps with three roundings, fewer than kNetError has.
  for (PatchNet* net : {&x[0], &x[1], &x[2], &w}) {
    cut_u(*net, side_u.high, false);
    cut_u(*net, side_u.low / side_u.high, true);
    cut_v(*net, side_v.high, false);
    cut_v(*net, side_v.low / side_v.high, true);
  }
  // Seen from a point within, so that little is left that weights could stretch.
  double error[3];
  for (int a = 0; a < 3; ++a) {
    error[a] = kNetError * size_of(x_[a]);
    const double from = x[a].c[w.m / 2][w.n / 2] / w.c[w.m / 2][w.n / 2];
    for (int i = 0; i <= w.m; ++i)
      for (int j = 0; j <= w.n; ++j) x[a].c[i][j] -= from * w.c[i][j];
  }
  const DerivativeBounds d = derivative_bounds_of(x, w, patch_.is_rational, error);
  // The curve's derivatives in units of the box.
  const double du = u.speed / side_u.half(), dv = v.speed / side_v.half();
  const double ddu = u.bend / side_u.half(), ddv = v.bend / side_v.half();
  double second[3];
  for (int a = 0; a < 3; ++a)
    second[a] =
        d.xx[a] * du * du + 2 * d.xy[a] * du * dv + d.yy[a] * dv * dv + d.x[a] * ddu + d.y[a] * ddv;
  return length(Vec3d{second[0], second[1], second[2]}) * patch_.extent / 8;
}

}  // namespace tessera::core
