// SPDX-License-Identifier: Apache-2.0
// The complete solver (complete_solver.h) for degrees up to 3, with its method and its bounds, but
// for these. It begins with the part of the square that may hold roots. Points are raised to degree
// 3 in both directions: at most four more roundings of means, among the 1024 that its noise stands
// for. A net is four registers of four numbers.
//
// Narrowing. With Y about the inverse of F', let g = Y F have control numbers g_ij, whose places
// are c_i by the first axis, and let s >= 0. At a root sum B_i B_j g_ij = 0 and sum B_i c_i = x, so
// x = sum B_i B_j (c_i - s g_ij), which lies between the least and the greatest of c_i - s g_ij;
// and so by the second axis. s = 1 is Krawczyk's operator; smaller ones narrow boxes over which F'
// changes much, where g rises faster somewhere than in the middle. A box that no share narrows is
// halved along the axis along which F' changes more.
//
// Newton begins where r <= 7/16. With s the size of a step in half widths of the box, a step that
// is not clamped leaves F, times the inverse of F' anywhere in the box, at r / (2 (1 - r)) s^2 =
// 0.39 s^2 at most, which bounds the next step. A step within the box has s <= 2, so steps become
// smaller, and none ends where F is not small. Newton ends at steps of 2^-20 of the box: what is
// left is below 2^-39 of it, and t, of the tangent plane before that step, is as near to that of
// the root.
//
// Threads. Pure functions.
#include "slave/core/primitive/patch/cubic_solver_layout.h"

#if defined(TESSERA_CORE_CUBIC_SOLVER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_CUBIC_SOLVER_INL_H_
#undef TESSERA_CORE_CUBIC_SOLVER_INL_H_
#else
#define TESSERA_CORE_CUBIC_SOLVER_INL_H_
#endif

#include "slave/core/primitive/patch/cubic_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// As in complete_solver.cpp, but for kContraction, kRestricted and kShares.
struct CubicSolverLimits {
  static constexpr double kNoiseShare = 0x1p-42;
  static constexpr double kFlat = 0x1p-32;
  static constexpr double kLeastWidth = 0x1p-44;
  static constexpr double kContraction = 0.4375;
  static constexpr double kRestricted = 0.8;
  static constexpr double kWorthACut = 0.95;
  static constexpr double kNetRoundings = 0x1p-40;
  static constexpr double kShares[] = {1, 0.4, 0.16};
  static constexpr double kWellConditioned = 0x1p-24;
  static constexpr double kEvaluation = 0x1p-46;
  static constexpr double kOverlap = 0x1p-24;
  static constexpr double kLastStep = 0x1p-20;
  static constexpr int kNewtonStepsMax = 24;
};

class CubicSolver : CubicSolverLimits {
 public:
  HWY_INLINE CubicSolver(const Patch& patch, const SubPatch& part, const float* origin,
                         const float* direction, const float* t_range);
  HWY_INLINE void run(SolvedPatch& to);

 private:
  static constexpr int kStackMax = 96;

  // The part of a box, in its own square, that may hold roots.
  struct Narrowed {
    double low[2] = {-1, -1}, high[2] = {1, 1};
    double r = __builtin_inf();
    double change[2] = {0, 0};  // of F' along each axis; 0 where nothing is known
    bool is_empty() const { return !(low[0] <= high[0] && low[1] <= high[1]); }
    double kept(int axis) const { return 0.5 * (high[axis] - low[axis]); }
  };
  // Ranges of derivatives, [function][axis].
  struct Slopes {
    double low[2][2], high[2][2];
    double middle(int k, int axis) const { return 0.5 * (low[k][axis] + high[k][axis]); }
    double radius(int k, int axis) const { return 0.5 * (high[k][axis] - low[k][axis]); }
    double size(int axis) const {
      return max_of(max_of(high[0][axis], -low[0][axis]), max_of(high[1][axis], -low[1][axis]));
    }
  };

  HWY_INLINE bool find_square(const SubPatch& part, const float* origin, double extent);
  HWY_INLINE void project();
  HWY_INLINE void step();
  HWY_INLINE Narrowed narrowed(const CubicBox& box, const Slopes& slopes) const;
  HWY_INLINE void shrink(CubicBox& box, int axis, double from, double to) const;
  HWY_INLINE void halve(int axis);
  HWY_INLINE void accept_flat(const CubicBox& box);
  HWY_INLINE void newton(const CubicBox& box, const Narrowed& to);
  HWY_INLINE void report(double t, double x, double y);

  CubicPoints points_;
  Triple direction_;
  double t_min_, t_max_;
  double noise_ = 0, noise_f_ = 0, flat_ = 0;
  SolvedPatch best_{};
  int depth_ = 1;
  CubicBox stack_[kStackMax];
};

CubicSolver::CubicSolver(const Patch& patch, const SubPatch& part, const float* origin,
                         const float* direction, const float* t_range)
    : points_(part),
      direction_{static_cast<double>(direction[0]), static_cast<double>(direction[1]),
                 static_cast<double>(direction[2])},
      t_min_(static_cast<double>(t_range[0])),
      t_max_(static_cast<double>(t_range[1])) {
  if (!find_square(part, origin, patch.extent)) {
    depth_ = 0;
    return;
  }
  points_.load(patch, origin);
  noise_ = kEvaluation * points_.far;
  noise_f_ = kNoiseShare * points_.far * points_.high_w;
  flat_ = kFlat * patch.extent * points_.low_w + 2 * noise_f_;
  project();
}

// Sets the first box: the square, or the part of it around where the ray passes the plane of the
// frame that holds all roots, as patch_decision-inl.h has it in 1. Where the ray is along the
// plane, no comparison holds, and the box is the square. Returns: whether there may be roots.
bool CubicSolver::find_square(const SubPatch& part, const float* origin, double extent) {
  CubicBox& box = stack_[0];
  for (int a = 0; a < 2; ++a) {
    box.low[a] = -1 - kSquareWiden;
    box.high[a] = 1 + kSquareWiden;
  }
  if (!part.has_frame) return true;
  double from[3], o[3], d[3], norm[3], far = 0;
  for (int k = 0; k < 3; ++k) {
    from[k] = static_cast<double>(origin[k]) - static_cast<double>(part.centre[k]);
    far = max_of(far, abs_of(from[k]));
  }
  for (int r = 0; r < 3; ++r) {
    const Triple row{static_cast<double>(part.frame[r][0]), static_cast<double>(part.frame[r][1]),
                     static_cast<double>(part.frame[r][2])};
    o[r] = dot_of(row, {from[0], from[1], from[2]});
    d[r] = dot_of(row, direction_);
    norm[r] = abs_of(row.x) + abs_of(row.y) + abs_of(row.z);
  }
  const double noise = (far + 2 * extent) * kEvaluation, inverse = 1 / d[2];
  for (int a = 0; a < 2; ++a) {
    const double slope = d[a] * inverse, size = abs_of(slope), at = o[a] - o[2] * slope;
    const double reach = static_cast<double>(part.reach[a]) +
                         size * static_cast<double>(part.reach[2]) +
                         8 * ((norm[a] + size * norm[2]) * noise);
    if (at - reach > box.low[a]) box.low[a] = at - reach;
    if (at + reach < box.high[a]) box.high[a] = at + reach;
  }
  return box.low[0] <= box.high[0] && box.low[1] <= box.high[1];
}

// Takes F over the first box.
void CubicSolver::project() {
  const double size[3] = {abs_of(direction_.x), abs_of(direction_.y), abs_of(direction_.z)};
  int small = 0;
  for (int k = 1; k < 3; ++k)
    if (size[k] < size[small]) small = k;
  const Triple d = unit_of(direction_);
  const Triple axis{small == 0 ? 1.0 : 0.0, small == 1 ? 1.0 : 0.0, small == 2 ? 1.0 : 0.0};
  const Triple n[2] = {unit_of(cross_of(axis, d)), cross_of(d, unit_of(cross_of(axis, d)))};
  CubicBox& box = stack_[0];
  for (int i = 0; i < 4; ++i) {
    Quad by_axis[4];
    transpose(points_.point[i], by_axis);
    for (int k = 0; k < 2; ++k)
      box.f[k].row[i] = n[k].x * by_axis[0] + n[k].y * by_axis[1] + n[k].z * by_axis[2];
  }
  for (int a = 0; a < 2; ++a) {
    const double low = box.low[a], high = box.high[a];
    shrink(box, a, points_.middle[a] + points_.half[a] * low,
           points_.middle[a] + points_.half[a] * high);
    box.low[a] = low;
    box.high[a] = high;
  }
}

void CubicSolver::shrink(CubicBox& box, int axis, double from, double to) const {
  for (CubicNet& net : box.f) {
    if (axis == 0) {
      net.restrict_rows(from, to);
    } else {
      CubicNet other = net.transposed();
      other.restrict_rows(from, to);
      net = other.transposed();
    }
  }
  const double low = box.low[axis], width = box.high[axis] - low;
  box.low[axis] = low + from * width;
  box.high[axis] = low + to * width;
}

void CubicSolver::run(SolvedPatch& to) {
  while (depth_ > 0 && !best_.is_exhausted) {
    if (++best_.box_count > kSolverBoxesMax) {
      best_.is_exhausted = true;
    } else {
      step();
    }
  }
  to = best_;
}

void CubicSolver::step() {
  CubicBox& box = stack_[depth_ - 1];
  bool is_flat = true;
  for (const CubicNet& net : box.f) {
    double low = 0, high = 0;
    net.range(low, high);
    if (low > noise_f_ || high < -noise_f_) {
      --depth_;
      return;
    }
    is_flat = is_flat && 0.5 * (high - low) <= flat_;
  }
  const double width = max_of(box.high[0] - box.low[0], box.high[1] - box.low[1]);
  if (is_flat || width < kLeastWidth) {
    --depth_;
    return accept_flat(box);
  }
  Slopes slopes;
  for (int k = 0; k < 2; ++k) {
    box.f[k].slope_range(slopes.low[k][0], slopes.high[k][0]);
    box.f[k].transposed().slope_range(slopes.low[k][1], slopes.high[k][1]);
  }
  const Narrowed to = narrowed(box, slopes);
  if (to.is_empty()) {
    --depth_;
  } else if (to.r <= kContraction) {
    --depth_;
    newton(box, to);
  } else if (min_of(to.kept(0), to.kept(1)) < kRestricted) {
    for (int a = 0; a < 2; ++a)
      if (to.kept(a) < kWorthACut) shrink(box, a, 0.5 * (1 + to.low[a]), 0.5 * (1 + to.high[a]));
  } else {
    const bool is_equal = to.change[0] == to.change[1];
    const bool by_u = to.change[0] > to.change[1] || (is_equal && slopes.size(0) >= slopes.size(1));
    halve(by_u ? 0 : 1);
  }
}

void CubicSolver::halve(int axis) {
  if (depth_ == kStackMax) {
    best_.is_exhausted = true;
    return;
  }
  CubicBox& box = stack_[depth_ - 1];
  CubicBox& other = stack_[depth_++];
  other = box;
  shrink(other, axis, 0, 0.5);
  shrink(box, axis, 0.5, 1);
}

CubicSolver::Narrowed CubicSolver::narrowed(const CubicBox& box, const Slopes& slopes) const {
  Narrowed to;
  const double a = slopes.middle(0, 0), b = slopes.middle(0, 1);
  const double c = slopes.middle(1, 0), d = slopes.middle(1, 1);
  const double determinant = a * d - b * c;
  if (!(abs_of(determinant) > kWellConditioned * slopes.size(0) * slopes.size(1))) return to;
  const double y[2][2] = {{d / determinant, -b / determinant}, {-c / determinant, a / determinant}};
  constexpr double kPlace[4] = {-1, 2.0 / 3 - 1, 4.0 / 3 - 1, 1};
  to.r = 0;
  for (int k = 0; k < 2; ++k) {
    const double y0 = abs_of(y[k][0]), y1 = abs_of(y[k][1]);
    to.r = max_of(to.r, y0 * (slopes.radius(0, 0) + slopes.radius(0, 1)) +
                            y1 * (slopes.radius(1, 0) + slopes.radius(1, 1)));
    for (int a = 0; a < 2; ++a)
      to.change[a] = max_of(to.change[a], y0 * slopes.radius(0, a) + y1 * slopes.radius(1, a));
    CubicNet seen;  // columns by the place of the axis
    for (int i = 0; i < 4; ++i) seen.row[i] = y[k][0] * box.f[0].row[i] + y[k][1] * box.f[1].row[i];
    if (k == 0) seen = seen.transposed();
    double least[4], most[4];
    min(min(seen.row[0], seen.row[1]), min(seen.row[2], seen.row[3])).store(least);
    max(max(seen.row[0], seen.row[1]), max(seen.row[2], seen.row[3])).store(most);
    const double wide = (y0 + y1) * noise_f_ + kNetRoundings;
    for (const double share : kShares) {
      double low = __builtin_inf(), high = -__builtin_inf();
      for (int i = 0; i < 4; ++i) {
        low = min_of(low, kPlace[i] - share * most[i]);
        high = max_of(high, kPlace[i] - share * least[i]);
      }
      to.low[k] = max_of(to.low[k], low - wide);
      to.high[k] = min_of(to.high[k], high + wide);
    }
  }
  return to;
}

void CubicSolver::accept_flat(const CubicBox& box) {
  for (int k = 0; k < 2; ++k)
    if (box.low[k] > 1 + kOverlap || box.high[k] < -1 - kOverlap) return;
  const double x = 0.5 * (box.low[0] + box.high[0]), y = 0.5 * (box.low[1] + box.high[1]);
  report(dot_of(points_.jet_at(x, y).point, direction_) / dot_of(direction_, direction_), x, y);
}

void CubicSolver::newton(const CubicBox& box, const Narrowed& to) {
  double from[2], until[2], at[2], tolerance[2] = {}, t = 0;
  for (int k = 0; k < 2; ++k) {
    const double middle = 0.5 * (box.low[k] + box.high[k]), half = 0.5 * (box.high[k] - box.low[k]);
    from[k] = middle + half * to.low[k];
    until[k] = middle + half * to.high[k];
    at[k] = 0.5 * (from[k] + until[k]);
  }
  const Triple d = direction_;
  const double size = max_of(until[0] - from[0], until[1] - from[1]);
  double last = __builtin_inf();
  for (int step = 0;; ++step) {
    const CubicPoints::Jet jet = points_.jet_at(at[0], at[1]);
    const Triple c = cross_of(d, jet.point), n = cross_of(jet.du, jet.dv);
    const double unit = 1 / dot_of(n, d);
    t = dot_of(n, jet.point) * unit;
    const double moved[2] = {-dot_of(jet.dv, c) * unit, dot_of(jet.du, c) * unit};
    const double scale = 4 * noise_ * abs_of(unit) * length_of(d);
    tolerance[0] = kOverlap + scale * length_of(jet.dv);
    tolerance[1] = kOverlap + scale * length_of(jet.du);
    for (int k = 0; k < 2; ++k) at[k] += moved[k];
    const double now = max_of(abs_of(moved[0]), abs_of(moved[1]));
    if (now <= kLastStep * size || now <= 0x1p-34 || (step > 4 && now >= last) ||
        step == kNewtonStepsMax)
      break;
    last = now;
    for (int k = 0; k < 2; ++k) at[k] = min_of(max_of(at[k], from[k]), until[k]);
  }
  for (int k = 0; k < 2; ++k) {
    const double slack = 0x1p-16 * size + tolerance[k];
    if (!(abs_of(at[k]) <= 1 + tolerance[k])) return;
    if (!(at[k] >= from[k] - slack && at[k] <= until[k] + slack)) return;
  }
  report(t, at[0], at[1]);
}

void CubicSolver::report(double t, double x, double y) {
  if (!(t >= t_min_ && t <= t_max_)) return;
  if (best_.is_hit && !(t < best_.t)) return;
  best_.is_hit = true;
  best_.t = t;
  best_.u = points_.middle[0] + points_.half[0] * min_of(max_of(x, -1.0), 1.0);
  best_.v = points_.middle[1] + points_.half[1] * min_of(max_of(y, -1.0), 1.0);
}

inline void solve_cubic(const Patch& patch, const SubPatch& part, const float* origin,
                        const float* direction, const float* t_range, SolvedPatch& to) {
  CubicSolver(patch, part, origin, direction, t_range).run(to);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
