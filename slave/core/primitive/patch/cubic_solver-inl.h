// SPDX-License-Identifier: Apache-2.0
// The complete solver (complete_solver.h) for degrees up to 3, with its method and its bounds. Points
// are raised to degree 3 in both directions: at most four more roundings of means, among the 1024
// that its noise stands for. A net is four registers of four numbers.
//
// Threads. Pure functions.
#include "slave/core/primitive/patch/cubic_solver_layout.h"

#if defined(TESSERA_CORE_CUBIC_SOLVER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_CUBIC_SOLVER_INL_H_
#undef TESSERA_CORE_CUBIC_SOLVER_INL_H_
#else
#define TESSERA_CORE_CUBIC_SOLVER_INL_H_
#endif

#include "slave/core/primitive/patch/quad-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Vectors of three.
struct Triple {
  double x, y, z;
};
HWY_INLINE Triple operator*(double a, Triple v) { return {a * v.x, a * v.y, a * v.z}; }
HWY_INLINE double dot_of(Triple a, Triple b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
HWY_INLINE Triple cross_of(Triple a, Triple b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
HWY_INLINE double length_of(Triple a) { return __builtin_sqrt(dot_of(a, a)); }
HWY_INLINE Triple unit_of(Triple a) { return (1 / length_of(a)) * a; }

// Row i, column j: of B_i(u) B_j(v).
struct CubicNet {
  Quad row[4];

  HWY_INLINE CubicNet transposed() const {
    CubicNet other;
    transpose(row, other.row);
    return other;
  }
  HWY_INLINE void range(double& low, double& high) const {
    low = min(min(row[0], row[1]), min(row[2], row[3])).least();
    high = max(max(row[0], row[1]), max(row[2], row[3])).greatest();
  }
  // The range of the derivative by the parameter of the rows, where the square is [-1, 1]^2.
  HWY_INLINE void slope_range(double& low, double& high) const {
    const Quad a = row[1] - row[0], b = row[2] - row[1], c = row[3] - row[2];
    low = 1.5 * min(min(a, b), c).least();
    high = 1.5 * max(max(a, b), c).greatest();
  }
  // Keeps [from, to] of the parameter of the rows, by de Casteljau's scheme.
  HWY_INLINE void restrict_rows(double from, double to) {
    if (to != 1) {
      for (int k = 1; k <= 3; ++k)
        for (int i = 3; i >= k; --i) row[i] = (1 - to) * row[i - 1] + to * row[i];
    }
    const double a = from / to;
    if (from != 0) {
      for (int k = 1; k <= 3; ++k)
        for (int i = 0; i <= 3 - k; ++i) row[i] = (1 - a) * row[i] + a * row[i + 1];
    }
  }
};

struct CubicBox {
  double low[2], high[2];  // in the sub-patch's square
  CubicNet f[2];
};

class CubicSolver {
 public:
  HWY_INLINE CubicSolver(const Patch& patch, const SubPatch& part, const float* origin,
                         const float* direction, const float* t_range);
  HWY_INLINE void run(SolvedPatch& to);

 private:
  static constexpr double kNoiseShare = 0x1p-42;       // as complete_solver.cpp has them
  static constexpr double kFlat = 0x1p-32;
  static constexpr double kLeastWidth = 0x1p-44;
  static constexpr double kContraction = 0.25;
  static constexpr double kRestricted = 0.7;
  static constexpr double kWorthACut = 0.95;
  static constexpr double kNetRoundings = 0x1p-40;
  static constexpr double kWellConditioned = 0x1p-24;
  static constexpr double kEvaluation = 0x1p-46;
  static constexpr double kOverlap = 0x1p-24;
  static constexpr int kNewtonStepsMax = 24;
  static constexpr int kStackMax = 96;

  // The part of a box, in its own square, that may hold roots.
  struct Narrowed {
    double low[2] = {-1, -1}, high[2] = {1, 1};
    double r = __builtin_inf();
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
  struct Jet {
    Triple point, du, dv;  // derivatives by x, y
  };

  HWY_INLINE void load(const Patch& patch, const float* origin);
  HWY_INLINE void project();
  HWY_INLINE void step();
  HWY_INLINE Narrowed narrowed(const CubicBox& box, const Slopes& slopes) const;
  HWY_INLINE void shrink(CubicBox& box, int axis, double from, double to) const;
  HWY_INLINE void halve(int axis);
  HWY_INLINE Jet jet_at(double x, double y) const;
  HWY_INLINE void accept_flat(const CubicBox& box);
  HWY_INLINE void newton(const CubicBox& box, const Narrowed& to);
  HWY_INLINE void report(double t, double x, double y);

  Quad point_[4][4];  // w x, w y, w z, w relative to the origin
  Triple direction_;
  bool is_rational_;
  double half_[2], middle_[2];  // of the sub-patch's range
  double t_min_, t_max_;
  double far_ = 0, low_w_ = 1, high_w_ = 1;
  double noise_ = 0, noise_f_ = 0, flat_ = 0;
  SolvedPatch best_{};
  int depth_ = 1;
  CubicBox stack_[kStackMax];
};

CubicSolver::CubicSolver(const Patch& patch, const SubPatch& part, const float* origin,
                         const float* direction, const float* t_range)
    : direction_{static_cast<double>(direction[0]), static_cast<double>(direction[1]),
                 static_cast<double>(direction[2])},
      is_rational_(patch.is_rational),
      t_min_(static_cast<double>(t_range[0])),
      t_max_(static_cast<double>(t_range[1])) {
  half_[0] = 1.0 / (2u << part.level_u);
  half_[1] = 1.0 / (2u << part.level_v);
  middle_[0] = (2 * part.column + 1) * half_[0];
  middle_[1] = (2 * part.row + 1) * half_[1];
  load(patch, origin);
  noise_ = kEvaluation * far_;
  noise_f_ = kNoiseShare * far_ * high_w_;
  flat_ = kFlat * patch.extent * low_w_ + 2 * noise_f_;
  project();
}

// Takes the points relative to the origin, raised to degree 3.
void CubicSolver::load(const Patch& patch, const float* origin) {
  const int m = patch.degree_u, n = patch.degree_v;
  alignas(32) const double from[4] = {static_cast<double>(origin[0]),
                                      static_cast<double>(origin[1]),
                                      static_cast<double>(origin[2]), 0};
  const Quad o = Quad::loaded(from);
  Quad size = Quad::all(0);
  double low_w = __builtin_inf(), high_w = 0;
  for (int i = 0; i <= m; ++i) {
    for (int j = 0; j <= n; ++j) {
      const PatchPoint& p = patch.points[(n + 1) * i + j];
      const double w = p.x[3];
      const Quad q = Quad::loaded(p.x) - w * o;
      point_[i][j] = q;
      Quad s = max(q, Quad::all(0) - q);
      if (is_rational_) {
        s = (1 / w) * s;
        low_w = min_of(low_w, w);
        high_w = max_of(high_w, w);
      }
      size = max(size, s);
    }
    for (int k = n + 1; k <= 3; ++k)  // from degree k - 1 to k
      for (int j = k; j >= 0; --j) {
        const double a = static_cast<double>(j) / k;
        point_[i][j] = j == k   ? point_[i][j - 1]
                       : j == 0 ? point_[i][0]
                                : a * point_[i][j - 1] + (1 - a) * point_[i][j];
      }
  }
  for (int k = m + 1; k <= 3; ++k)
    for (int i = k; i >= 0; --i) {
      const double a = static_cast<double>(i) / k;
      for (int j = 0; j <= 3; ++j)
        point_[i][j] = i == k   ? point_[i - 1][j]
                       : i == 0 ? point_[0][j]
                                : a * point_[i - 1][j] + (1 - a) * point_[i][j];
    }
  double sizes[4];
  size.store(sizes);
  far_ = max_of(max_of(sizes[0], sizes[1]), sizes[2]);
  if (is_rational_) {
    low_w_ = low_w;
    high_w_ = high_w;
  }
}

// Makes the first box: F over the whole square.
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
    transpose(point_[i], by_axis);
    for (int k = 0; k < 2; ++k)
      box.f[k].row[i] = n[k].x * by_axis[0] + n[k].y * by_axis[1] + n[k].z * by_axis[2];
  }
  for (int a = 0; a < 2; ++a) {
    const double half = half_[a] * (1 + kSquareWiden);
    box.low[a] = 0;
    box.high[a] = 1;
    shrink(box, a, middle_[a] - half, middle_[a] + half);
    box.low[a] = -1 - kSquareWiden;
    box.high[a] = 1 + kSquareWiden;
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
    halve(slopes.size(0) >= slopes.size(1) ? 0 : 1);
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
  alignas(32) static constexpr double kPlace[4] = {-1, 2.0 / 3 - 1, 4.0 / 3 - 1, 1};
  const Quad columns = Quad::loaded(kPlace);
  to.r = 0;
  for (int k = 0; k < 2; ++k) {
    const double y0 = abs_of(y[k][0]), y1 = abs_of(y[k][1]);
    to.r = max_of(to.r, y0 * (slopes.radius(0, 0) + slopes.radius(0, 1)) +
                            y1 * (slopes.radius(1, 0) + slopes.radius(1, 1)));
    CubicNet rest;
    for (int i = 0; i < 4; ++i) {
      const Quad place = k == 0 ? Quad::all(kPlace[i]) : columns;
      rest.row[i] = y[k][0] * box.f[0].row[i] + y[k][1] * box.f[1].row[i] - place;
    }
    double low = 0, high = 0;
    rest.range(low, high);
    const double wide = (y0 + y1) * noise_f_ + kNetRoundings;
    to.low[k] = max_of(to.low[k], -high - wide);
    to.high[k] = min_of(to.high[k], -low + wide);
  }
  return to;
}

CubicSolver::Jet CubicSolver::jet_at(double x, double y) const {
  const double at[2] = {middle_[0] + half_[0] * x, middle_[1] + half_[1] * y};
  double weight[2][4], slope[2][4];
  for (int a = 0; a < 2; ++a) {
    const double u = at[a], v = 1 - u, uu = u * u, vv = v * v, uv = 2 * (u * v);
    weight[a][0] = vv * v;
    weight[a][1] = 3 * (vv * u);
    weight[a][2] = 3 * (uu * v);
    weight[a][3] = uu * u;
    const double h = 3 * half_[a];
    slope[a][0] = -h * vv;
    slope[a][1] = h * (vv - uv);
    slope[a][2] = h * (uv - uu);
    slope[a][3] = h * uu;
  }
  Quad sums[3] = {Quad::all(0), Quad::all(0), Quad::all(0)};
  for (int i = 0; i < 4; ++i) {
    const Quad* const p = point_[i];
    const Quad value = (weight[1][0] * p[0] + weight[1][1] * p[1]) +
                       (weight[1][2] * p[2] + weight[1][3] * p[3]);
    const Quad across = (slope[1][0] * p[0] + slope[1][1] * p[1]) +
                        (slope[1][2] * p[2] + slope[1][3] * p[3]);
    sums[0] = sums[0] + weight[0][i] * value;
    sums[1] = sums[1] + slope[0][i] * value;
    sums[2] = sums[2] + weight[0][i] * across;
  }
  double of[3][4];
  for (int k = 0; k < 3; ++k) sums[k].store(of[k]);
  if (!is_rational_)
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

void CubicSolver::accept_flat(const CubicBox& box) {
  for (int k = 0; k < 2; ++k)
    if (box.low[k] > 1 + kOverlap || box.high[k] < -1 - kOverlap) return;
  const double x = 0.5 * (box.low[0] + box.high[0]), y = 0.5 * (box.low[1] + box.high[1]);
  report(dot_of(jet_at(x, y).point, direction_) / dot_of(direction_, direction_), x, y);
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
    const Jet jet = jet_at(at[0], at[1]);
    const Triple c = cross_of(d, jet.point), n = cross_of(jet.du, jet.dv);
    const double unit = 1 / dot_of(n, d);
    t = dot_of(n, jet.point) * unit;
    const double moved[2] = {-dot_of(jet.dv, c) * unit, dot_of(jet.du, c) * unit};
    const double scale = 4 * noise_ * abs_of(unit) * length_of(d);
    tolerance[0] = kOverlap + scale * length_of(jet.dv);
    tolerance[1] = kOverlap + scale * length_of(jet.du);
    for (int k = 0; k < 2; ++k) at[k] += moved[k];
    const double now = max_of(abs_of(moved[0]), abs_of(moved[1]));
    if (now <= 0x1p-17 * size || now <= 0x1p-34 || (step > 4 && now >= last) ||
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
  best_.u = middle_[0] + half_[0] * min_of(max_of(x, -1.0), 1.0);
  best_.v = middle_[1] + half_[1] * min_of(max_of(y, -1.0), 1.0);
}

inline void solve_cubic(const Patch& patch, const SubPatch& part, const float* origin,
                        const float* direction, const float* t_range, SolvedPatch& to) {
  CubicSolver(patch, part, origin, direction, t_range).run(to);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
