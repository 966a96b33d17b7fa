// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/complete_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/vec3d.h"
#include "slave/core/primitive/patch/cubic_solver_abi.h"
#include "slave/core/primitive/patch/patch_decision.h"
#include "slave/core/primitive/patch/sub_patch_range.h"

namespace tessera::core {
namespace {

constexpr double kNoiseShare = 0x1p-42;       // of R w: see the header
constexpr double kFlat = 0x1p-32;             // of the patch's extent
constexpr double kLeastWidth = 0x1p-44;       // of a box in the square: x is no better known
constexpr double kContraction = 0.25;         // r at which Newton begins
constexpr double kRestricted = 0.7;           // of a side, for a box to be restricted
constexpr double kWorthACut = 0.95;           // of the other side, for it to be cut as well
constexpr double kNetRoundings = 0x1p-40;     // of Y F, whose net has numbers of some size 1
constexpr double kWellConditioned = 0x1p-24;  // of |F_x| |F_y|, for Y to be worth its roundings
constexpr int kNewtonStepsMax = 24;

struct Interval {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  double middle() const { return 0.5 * (low + high); }
  double radius() const { return 0.5 * (high - low); }
  double size() const { return std::max(high, -low); }
  void add(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
};

Vec3d vector(const double (&a)[3]) { return {a[0], a[1], a[2]}; }

// The range of the derivative of a net by x (0) or y (1), where its square is [-1, 1]^2.
Interval slope_of(const double* f, int m, int n, int axis) {
  Interval s;
  const int stride = n + 1;
  if (axis == 0) {
    for (int k = 0; k < m * stride; ++k) s.add(f[k + stride] - f[k]);
  } else {
    for (int i = 0; i <= m; ++i)
      for (int j = 0; j < n; ++j) s.add(f[stride * i + j + 1] - f[stride * i + j]);
  }
  const double half = 0.5 * (axis == 0 ? m : n);
  return {half * s.low, half * s.high};
}

}  // namespace

// Ranges of the derivatives of F over a box, by its own square.
struct CompleteSolver::Jacobian {
  Interval by[2][2];  // [k][axis]

  Jacobian(const Box& box, int m, int n) {
    for (int k = 0; k < 2; ++k)
      for (int axis = 0; axis < 2; ++axis) by[k][axis] = slope_of(box.f[k], m, n, axis);
  }
  double size(int axis) const { return std::max(by[0][axis].size(), by[1][axis].size()); }
};

// The part of a box, in its own square, that may hold roots; r as in the header.
struct CompleteSolver::Narrowed {
  double low[2] = {-1, -1}, high[2] = {1, 1};
  double r = std::numeric_limits<double>::infinity();

  bool is_empty() const { return !(low[0] <= high[0] && low[1] <= high[1]); }
  double kept(int axis) const { return 0.5 * (high[axis] - low[axis]); }
};

PatchHit CompleteSolver::solve(const Patch& patch, const SubPatch& part, const PatchRay& ray) {
  if (std::max(patch.degree_u, patch.degree_v) <= kCubicMax) {
    static const CubicSolverCall solve_cubic = widest_cubic_solver();
    const float t_range[2] = {ray.t_min, ray.t_max};
    SolvedPatch solved;
    solve_cubic(patch, part, ray.origin, ray.direction, t_range, solved);
    box_count_ = solved.box_count;
    is_exhausted_ = solved.is_exhausted;
    return {solved.is_hit, solved.t, solved.u, solved.v};
  }
  set_up(patch, part, ray);
  while (depth_ > 0 && !is_exhausted_) {
    if (++box_count_ > kBoxesMax) {
      is_exhausted_ = true;
    } else {
      step();
    }
  }
  return best_;
}

void CompleteSolver::set_up(const Patch& patch, const SubPatch& part, const PatchRay& ray) {
  part_ = part;
  ray_ = ray;
  best_ = {};
  depth_ = 1;
  box_count_ = 0;
  is_exhausted_ = false;
  int small = 0;
  for (int k = 0; k < 3; ++k) {
    direction_[k] = double{ray.direction[k]};
    if (std::fabs(direction_[k]) < std::fabs(direction_[small])) small = k;
  }
  const Vec3d d = normalize(vector(direction_));
  const Vec3d axis{small == 0 ? 1.0 : 0.0, small == 1 ? 1.0 : 0.0, small == 2 ? 1.0 : 0.0};
  const Vec3d n1 = normalize(cross(axis, d)), n2 = cross(d, n1);
  Box& box = stack_[0];
  double far = 0, low_w = std::numeric_limits<double>::infinity(), high_w = 0;
  for (int k = 0; k < (patch.degree_u + 1) * (patch.degree_v + 1); ++k) {
    PatchPoint& p = points_[k];
    const PatchPoint from = plain::point_of(patch, k);
    const double w = from.x[3];
    for (int a = 0; a < 3; ++a) {
      p.x[a] = from.x[a] - double{ray.origin[a]} * w;
      far = std::max(far, std::fabs(p.x[a]) / w);
    }
    p.x[3] = w;
    const Vec3d x{p.x[0], p.x[1], p.x[2]};
    box.f[0][k] = dot(n1, x);
    box.f[1][k] = dot(n2, x);
    low_w = std::min(low_w, w);
    high_w = std::max(high_w, w);
  }
  shifted_ = patch;
  noise_ = plain::kEvaluationError * far;
  noise_f_ = kNoiseShare * far * high_w;
  flat_ = kFlat * patch.extent * low_w + 2 * noise_f_;
  const SubPatchRange range(part);
  const double half[2] = {range.half_u * (1 + kSquareWiden), range.half_v * (1 + kSquareWiden)};
  const double middle[2] = {range.middle_u, range.middle_v};
  for (int a = 0; a < 2; ++a) {
    box.low[a] = -1 - kSquareWiden;
    box.high[a] = 1 + kSquareWiden;
    for (double* f : {box.f[0], box.f[1]})
      restrict_net(f, a, middle[a] - half[a], middle[a] + half[a]);
  }
}

// Keeps [from, to] of [0, 1] of one parameter.
void CompleteSolver::restrict_net(double* f, int axis, double from, double to) const {
  if (to != 1) cut(f, axis, to, false);
  if (from != 0) cut(f, axis, from / to, true);
}

// Keeps [a, 1] or [0, a], by de Casteljau's scheme.
void CompleteSolver::cut(double* f, int axis, double a, bool keeps_high) const {
  const int m = shifted_.degree_u, n = shifted_.degree_v;
  const int stride = n + 1, degree = axis == 0 ? m : n;
  const double b = 1 - a;
  for (int k = 1; k <= degree; ++k)
    for (int q = 0; q <= degree - k; ++q) {
      const int i = keeps_high ? q : degree - q, low = keeps_high ? i : i - 1;
      if (axis == 0) {
        for (int j = 0; j < stride; ++j)
          f[stride * i + j] = b * f[stride * low + j] + a * f[stride * (low + 1) + j];
      } else {
        for (int j = 0; j <= m; ++j)
          f[stride * j + i] = b * f[stride * j + low] + a * f[stride * j + low + 1];
      }
    }
}

void CompleteSolver::shrink(Box& box, int axis, double from, double to) const {
  for (double* f : {box.f[0], box.f[1]}) restrict_net(f, axis, from, to);
  const double low = box.low[axis], width = box.high[axis] - low;
  box.low[axis] = low + from * width;
  box.high[axis] = low + to * width;
}

bool CompleteSolver::is_elsewhere(const Box& box, bool& is_flat) const {
  const int count = (shifted_.degree_u + 1) * (shifted_.degree_v + 1);
  is_flat = true;
  for (const double* f : {box.f[0], box.f[1]}) {
    Interval range;
    for (int k = 0; k < count; ++k) range.add(f[k]);
    if (range.low > noise_f_ || range.high < -noise_f_) return true;
    is_flat = is_flat && range.radius() <= flat_;
  }
  return false;
}

void CompleteSolver::step() {
  Box& box = stack_[depth_ - 1];
  bool is_flat = false;
  if (is_elsewhere(box, is_flat)) {
    --depth_;
    return;
  }
  const double width = std::max(box.high[0] - box.low[0], box.high[1] - box.low[1]);
  if (is_flat || width < kLeastWidth) {
    --depth_;
    accept_flat(box);
    return;
  }
  const Jacobian jacobian(box, shifted_.degree_u, shifted_.degree_v);
  const Narrowed to = narrowed(box, jacobian);
  if (to.is_empty()) {
    --depth_;
  } else if (to.r <= kContraction) {
    --depth_;
    newton(box, to);
  } else if (std::min(to.kept(0), to.kept(1)) < kRestricted) {
    for (int a = 0; a < 2; ++a)
      if (to.kept(a) < kWorthACut) shrink(box, a, 0.5 * (1 + to.low[a]), 0.5 * (1 + to.high[a]));
  } else {
    halve(jacobian.size(0) >= jacobian.size(1) ? 0 : 1);
  }
}

void CompleteSolver::halve(int axis) {
  if (depth_ == kStackMax) {
    is_exhausted_ = true;
    return;
  }
  Box& box = stack_[depth_ - 1];
  Box& other = stack_[depth_++];
  const int count = (shifted_.degree_u + 1) * (shifted_.degree_v + 1);
  for (int k = 0; k < 2; ++k) {
    other.low[k] = box.low[k];
    other.high[k] = box.high[k];
    std::copy(box.f[k], box.f[k] + count, other.f[k]);
  }
  shrink(other, axis, 0, 0.5);
  shrink(box, axis, 0.5, 1);
}

CompleteSolver::Narrowed CompleteSolver::narrowed(const Box& box, const Jacobian& jacobian) const {
  Narrowed to;
  const double a = jacobian.by[0][0].middle(), b = jacobian.by[0][1].middle();
  const double c = jacobian.by[1][0].middle(), d = jacobian.by[1][1].middle();
  const double determinant = a * d - b * c;
  if (!(std::fabs(determinant) > kWellConditioned * jacobian.size(0) * jacobian.size(1))) return to;
  const double y[2][2] = {{d / determinant, -b / determinant}, {-c / determinant, a / determinant}};
  const int m = shifted_.degree_u, n = shifted_.degree_v;
  to.r = 0;
  for (int k = 0; k < 2; ++k) {
    const double y0 = std::fabs(y[k][0]), y1 = std::fabs(y[k][1]);
    to.r = std::max(to.r, y0 * (jacobian.by[0][0].radius() + jacobian.by[0][1].radius()) +
                              y1 * (jacobian.by[1][0].radius() + jacobian.by[1][1].radius()));
    Interval rest;
    const double scale = 2.0 / (k == 0 ? m : n);
    for (int i = 0; i <= m; ++i)
      for (int j = 0; j <= n; ++j) {
        const int at = (n + 1) * i + j;
        rest.add(y[k][0] * box.f[0][at] + y[k][1] * box.f[1][at] - ((k == 0 ? i : j) * scale - 1));
      }
    const double wide = (y0 + y1) * noise_f_ + kNetRoundings;
    to.low[k] = std::max(to.low[k], -rest.high - wide);
    to.high[k] = std::min(to.high[k], -rest.low + wide);
  }
  return to;
}

void CompleteSolver::accept_flat(const Box& box) {
  for (int k = 0; k < 2; ++k)
    if (box.low[k] > 1 + plain::kPatchOverlap || box.high[k] < -1 - plain::kPatchOverlap) return;
  const double x = 0.5 * (box.low[0] + box.high[0]), y = 0.5 * (box.low[1] + box.high[1]);
  const SubPatchRange range(part_);
  const PatchJet jet = evaluate(shifted_, points_, range.middle_u + range.half_u * x,
                                range.middle_v + range.half_v * y);
  const Vec3d d = vector(direction_);
  report(dot(vector(jet.point), d) / dot(d, d), x, y);
}

// Newton's iteration, clamped to what may hold the root. Where the steps are below 2^-17 of it, the
// error is below 2^-32 of it; where roundings keep steps from shrinking, it has done what it can.
// The root that is found lies there, to the tolerance (patch_decision-inl.h, 7) and the last step.
void CompleteSolver::newton(const Box& box, const Narrowed& to) {
  double from[2] = {}, until[2] = {}, at[2] = {}, tolerance[2] = {}, t = 0;
  for (int k = 0; k < 2; ++k) {
    const double middle = 0.5 * (box.low[k] + box.high[k]), half = 0.5 * (box.high[k] - box.low[k]);
    from[k] = middle + half * to.low[k];
    until[k] = middle + half * to.high[k];
    at[k] = 0.5 * (from[k] + until[k]);
  }
  const SubPatchRange range(part_);
  const Vec3d d = vector(direction_);
  const double size = std::max(until[0] - from[0], until[1] - from[1]);
  double last = std::numeric_limits<double>::infinity();
  for (int step = 0;; ++step) {
    const PatchJet jet = evaluate(shifted_, points_, range.middle_u + range.half_u * at[0],
                                  range.middle_v + range.half_v * at[1]);
    const Vec3d s = vector(jet.point), du = range.half_u * vector(jet.du),
                dv = range.half_v * vector(jet.dv);
    const Vec3d c = cross(d, s), n = cross(du, dv);
    const double unit = 1 / dot(n, d);
    t = dot(n, s) * unit;
    const double moved[2] = {-dot(dv, c) * unit, dot(du, c) * unit};
    const double scale = 4 * noise_ * std::fabs(unit) * length(d);
    tolerance[0] = plain::kPatchOverlap + scale * length(dv);
    tolerance[1] = plain::kPatchOverlap + scale * length(du);
    for (int k = 0; k < 2; ++k) at[k] += moved[k];
    const double now = std::max(std::fabs(moved[0]), std::fabs(moved[1]));
    if (now <= 0x1p-17 * size || now <= 0x1p-34 || (step > 4 && now >= last) ||
        step == kNewtonStepsMax)
      break;
    last = now;
    for (int k = 0; k < 2; ++k) at[k] = std::min(std::max(at[k], from[k]), until[k]);
  }
  for (int k = 0; k < 2; ++k) {
    const double slack = 0x1p-16 * size + tolerance[k];
    if (!(std::fabs(at[k]) <= 1 + tolerance[k])) return;
    if (!(at[k] >= from[k] - slack && at[k] <= until[k] + slack)) return;
  }
  report(t, at[0], at[1]);
}

void CompleteSolver::report(double t, double x, double y) {
  if (!(t >= double{ray_.t_min} && t <= double{ray_.t_max})) return;
  if (best_.is_hit && !(t < best_.t)) return;
  const SubPatchRange range(part_);
  x = std::min(std::max(x, -1.0), 1.0);
  y = std::min(std::max(y, -1.0), 1.0);
  best_ = {true, t, range.middle_u + range.half_u * x, range.middle_v + range.half_v * y};
}

}  // namespace tessera::core
