// SPDX-License-Identifier: Apache-2.0
// The complete solver of cubics (cubic_solver-inl.h) for a register of questions at once, one in
// each lane. Lanes do what it does, operation by operation, so answers have its bits; they only
// wait for each other. First all boxes are gone through, and those with one root at most are noted;
// then Newton's iterations of the first box of each lane run, of the second, and so on. What is
// seldom and long is not done here, but asked of it from the start: many boxes, many halves, and
// boxes that are flat.
//
// Threads. Pure functions.
#include "slave/core/primitive/patch/cubic_solver_layout.h"

#if defined(TESSERA_CORE_CUBIC_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_CUBIC_LANES_INL_H_
#undef TESSERA_CORE_CUBIC_LANES_INL_H_
#else
#define TESSERA_CORE_CUBIC_LANES_INL_H_
#endif

#include "slave/core/primitive/patch/cubic_lane_points-inl.h"
#include "slave/core/primitive/patch/cubic_solver-inl.h"
#include "slave/core/primitive/patch/lane_notes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class CubicLanes {
  using V = Doubles;
  using M = MaskOf<V>;
  using Limits = CubicSolverLimits;

 public:
  static constexpr int kWidth = CubicLanePoints::kWidth;

  // Shape: questions, to [count], count from 1 to kWidth.
  HWY_INLINE void solve(const PatchQuestion* questions, int count, SolvedPatch* to);

 private:
  static constexpr int kBoxesMax = 48;    // beyond these a lane is asked of the other solver
  static constexpr int kHalvesMax = 6;    // that wait
  static constexpr int kRootsMax = 4;     // boxes that Newton's iteration ends
  static constexpr int kBoxNumbers = 36;  // of a half that waits: its nets and its limits

  // What the nets of a box say of it.
  struct Slopes {
    V low[2][2], high[2][2];  // [function][axis]
    HWY_INLINE V middle(int k, int axis) const { return 0.5 * (low[k][axis] + high[k][axis]); }
    HWY_INLINE V radius(int k, int axis) const { return 0.5 * (high[k][axis] - low[k][axis]); }
    HWY_INLINE V size(int axis) const {
      return max(max(high[0][axis], -low[0][axis]), max(high[1][axis], -low[1][axis]));
    }
  };
  struct Narrowed {
    V low[2], high[2], r;
    HWY_INLINE V kept(int axis) const { return 0.5 * (high[axis] - low[axis]); }
  };

  HWY_INLINE M find_square();
  HWY_INLINE void project();
  HWY_INLINE void cut();
  HWY_INLINE void step();
  HWY_INLINE Slopes slopes() const;
  HWY_INLINE Narrowed narrowed(const Slopes& slopes) const;
  HWY_INLINE void note(M where, const Narrowed& to);
  HWY_INLINE void halve(M where, M by_u);
  HWY_INLINE void leave(M where);
  HWY_INLINE void give_up(M where) {
    given_up_ |= bits_of<V>(where);
    active_ = and_not(where, active_);
  }
  HWY_INLINE void newton(int root);
  HWY_INLINE void report(M where, V t, V x, V y);

  CubicLanePoints points_;
  V noise_{}, noise_f_{}, flat_{};
  M active_{};
  uint32_t given_up_ = 0;
  V low_[2] = {}, high_[2] = {};  // of the box
  CubicLaneNet f_[2];
  LaneRange next_[2];  // of the box, what is looked at next
  V boxes_{}, has_hit_{}, t_{}, u_{}, v_{};
  LaneNotes<kHalvesMax, kBoxNumbers> halves_;
  uint32_t halved_by_u_[kHalvesMax] = {};
  LaneNotes<kRootsMax, 4> roots_;
};

void CubicLanes::solve(const PatchQuestion* questions, int count, SolvedPatch* to) {
  points_.load_all(questions, count);
  active_ = find_square() && first_lanes<V>(static_cast<size_t>(count));
  noise_ = Limits::kEvaluation * points_.far();
  noise_f_ = Limits::kNoiseShare * points_.far() * points_.high_w();
  flat_ = Limits::kFlat * points_.extent() * points_.low_w() + 2 * noise_f_;
  boxes_ = has_hit_ = t_ = u_ = v_ = set<V>(0);
  if (!is_none<V>(active_)) project();
  while (!is_none<V>(active_)) {
    step();
    cut();
  }
  int most = 0;
  for (int lane = 0; lane < count; ++lane) most = max_of(most, roots_.count[lane]);
  for (int root = 0; root < most; ++root) newton(root);
  alignas(64) double t[kWidth], u[kWidth], v[kWidth], boxes[kWidth];
  store(t_, t);
  store(u_, u);
  store(v_, v);
  store(boxes_, boxes);
  const uint32_t hits = bits_of<V>(has_hit_ != set<V>(0));
  for (int lane = 0; lane < count; ++lane) {
    const PatchQuestion& q = questions[lane];
    if ((given_up_ >> lane & 1) != 0) {
      solve_cubic(*q.patch, *q.part, q.origin, q.direction, q.t_range, to[lane]);
    } else {
      to[lane] = {t[lane], u[lane], v[lane], static_cast<int>(boxes[lane]), (hits >> lane & 1) != 0,
                  false};
    }
  }
}

// Sets the first boxes. Returns: the lanes that have one.
CubicLanes::M CubicLanes::find_square() {
  for (int a = 0; a < 2; ++a) {
    low_[a] = set<V>(-1 - kSquareWiden);
    high_[a] = set<V>(1 + kSquareWiden);
  }
  const LaneTriple direction = points_.direction();
  V from[3] = {}, o[3] = {}, d[3] = {}, norm[3] = {}, far = set<V>(0);
  for (int k = 0; k < 3; ++k) {
    from[k] = points_.origin(k) - points_.centre(k);
    far = max(far, abs(from[k]));
  }
  for (int r = 0; r < 3; ++r) {
    const LaneTriple row{points_.frame(r, 0), points_.frame(r, 1), points_.frame(r, 2)};
    o[r] = dot_of(row, LaneTriple{from[0], from[1], from[2]});
    d[r] = dot_of(row, direction);
    norm[r] = abs(row.x) + abs(row.y) + abs(row.z);
  }
  const V noise = (far + 2 * points_.extent()) * Limits::kEvaluation, inverse = 1 / d[2];
  const M has_frame = points_.has_frame();
  for (int a = 0; a < 2; ++a) {
    const V slope = d[a] * inverse, size = abs(slope), at = o[a] - o[2] * slope;
    const V reach =
        points_.reach(a) + size * points_.reach(2) + 8 * ((norm[a] + size * norm[2]) * noise);
    low_[a] = select(has_frame && at - reach > low_[a], at - reach, low_[a]);
    high_[a] = select(has_frame && at + reach < high_[a], at + reach, high_[a]);
  }
  return low_[0] <= high_[0] && low_[1] <= high_[1];
}

// Takes F over the first boxes.
void CubicLanes::project() {
  const LaneTriple direction = points_.direction();
  const V x = abs(direction.x), y = abs(direction.y), z = abs(direction.z);
  const M is_y = y < x, is_z = z < min(x, y);
  const V zero = set<V>(0), one = set<V>(1);
  const LaneTriple axis{select(is_y || is_z, zero, one), select(is_y && !is_z, one, zero),
                        select(is_z, one, zero)};
  const LaneTriple d = unit_of(direction), across = unit_of(cross_of(axis, d));
  const LaneTriple n[2] = {across, cross_of(d, across)};
  for (int number = 0; number < 16; ++number) {
    const LaneTriple p = points_.point(number);
    for (int k = 0; k < 2; ++k) f_[k].x[number] = n[k].x * p.x + n[k].y * p.y + n[k].z * p.z;
  }
  for (int a = 0; a < 2; ++a) {
    const V middle = points_.middle(a), half = points_.half(a);
    const LaneCuts cuts({middle + half * low_[a], middle + half * high_[a]});
    for (CubicLaneNet& net : f_) a == 0 ? net.cut<0>(cuts) : net.cut<1>(cuts);
  }
}

// Cuts all boxes to what is looked at next.
void CubicLanes::cut() {
  for (int a = 0; a < 2; ++a) {
    const LaneRange range = next_[a];
    const M is_whole = range.from == set<V>(0) && range.to == set<V>(1);
    if (is_all<V>(is_whole)) continue;
    const LaneCuts cuts(range);
    for (CubicLaneNet& net : f_) a == 0 ? net.cut<0>(cuts) : net.cut<1>(cuts);
    const V low = low_[a], width = high_[a] - low;
    low_[a] = select(is_whole, low, low + range.from * width);
    high_[a] = select(is_whole, high_[a], low + range.to * width);
  }
}

CubicLanes::Slopes CubicLanes::slopes() const {
  Slopes of;
  for (int k = 0; k < 2; ++k) {
    f_[k].slope_range<0>(of.low[k][0], of.high[k][0]);
    f_[k].slope_range<1>(of.low[k][1], of.high[k][1]);
  }
  return of;
}

// Looks at the present box of each lane.
void CubicLanes::step() {
  boxes_ = select(active_, boxes_ + 1, boxes_);
  give_up(active_ && boxes_ >= set<V>(kBoxesMax));
  M is_flat = active_, is_elsewhere = and_not(active_, active_);
  for (const CubicLaneNet& net : f_) {
    V low = {}, high = {};
    net.range(low, high);
    is_elsewhere = is_elsewhere || low > noise_f_ || high < -noise_f_;
    is_flat = is_flat && 0.5 * (high - low) <= flat_;
  }
  const V width = max(high_[0] - low_[0], high_[1] - low_[1]);
  give_up(active_ && !is_elsewhere && (is_flat || width < set<V>(Limits::kLeastWidth)));
  M is_gone = active_ && is_elsewhere;
  const M is_open = active_ && !is_elsewhere;
  next_[0] = next_[1] = LaneRange::whole();
  if (!is_none<V>(is_open)) {
    const Slopes of = slopes();
    const Narrowed to = narrowed(of);
    const M is_empty = is_open && !(to.low[0] <= to.high[0] && to.low[1] <= to.high[1]);
    const M ends = is_open && !is_empty && to.r <= set<V>(Limits::kContraction);
    const M goes_on = is_open && !is_empty && !ends;
    const M is_narrow = goes_on && min(to.kept(0), to.kept(1)) < set<V>(Limits::kRestricted);
    for (int a = 0; a < 2; ++a)
      next_[a].replace(is_narrow && to.kept(a) < set<V>(Limits::kWorthACut), 0.5 * (1 + to.low[a]),
                       0.5 * (1 + to.high[a]));
    is_gone = is_gone || is_empty || ends;
    if (!is_none<V>(ends)) note(ends, to);
    const M halves = goes_on && !is_narrow;
    if (!is_none<V>(halves)) halve(halves, of.size(0) >= of.size(1));
  }
  if (!is_none<V>(is_gone)) leave(is_gone && active_);
}

CubicLanes::Narrowed CubicLanes::narrowed(const Slopes& slopes) const {
  const V a = slopes.middle(0, 0), b = slopes.middle(0, 1);
  const V c = slopes.middle(1, 0), d = slopes.middle(1, 1);
  const V determinant = a * d - b * c;
  const M is_good = abs(determinant) > Limits::kWellConditioned * slopes.size(0) * slopes.size(1);
  const V y[2][2] = {{d / determinant, -b / determinant}, {-c / determinant, a / determinant}};
  constexpr double kPlace[4] = {-1, 2.0 / 3 - 1, 4.0 / 3 - 1, 1};
  Narrowed to = {{set<V>(-1), set<V>(-1)}, {set<V>(1), set<V>(1)}, set<V>(0)};
  for (int k = 0; k < 2; ++k) {
    const V y0 = abs(y[k][0]), y1 = abs(y[k][1]);
    to.r = max(to.r, y0 * (slopes.radius(0, 0) + slopes.radius(0, 1)) +
                         y1 * (slopes.radius(1, 0) + slopes.radius(1, 1)));
    V low = {}, high = {};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const int number = 4 * i + j;
        const V rest =
            y[k][0] * f_[0].x[number] + y[k][1] * f_[1].x[number] - kPlace[k == 0 ? i : j];
        low = number == 0 ? rest : min(low, rest);
        high = number == 0 ? rest : max(high, rest);
      }
    const V wide = (y0 + y1) * noise_f_ + Limits::kNetRoundings;
    to.low[k] = select(is_good, max(to.low[k], -high - wide), to.low[k]);
    to.high[k] = select(is_good, min(to.high[k], -low + wide), to.high[k]);
  }
  to.r = select(is_good, to.r, set<V>(__builtin_inf()));
  return to;
}

// Notes what may hold a root, for Newton's iteration.
void CubicLanes::note(M where, const Narrowed& to) {
  V from[2] = {}, until[2] = {};
  for (int k = 0; k < 2; ++k) {
    const V middle = 0.5 * (low_[k] + high_[k]), half = 0.5 * (high_[k] - low_[k]);
    from[k] = middle + half * to.low[k];
    until[k] = middle + half * to.high[k];
  }
  roots_.by_count(bits_of<V>(where), [&](int number, uint32_t lanes) HWY_ATTR {
    const M mask = mask_of<V>(lanes);
    if (number == kRootsMax) return give_up(mask);
    for (int k = 0; k < 2; ++k) {
      store_where(mask, from[k], roots_.rows[number][k]);
      store_where(mask, until[k], roots_.rows[number][2 + k]);
    }
  });
  for (uint32_t left = bits_of<V>(where && active_); left != 0; left &= left - 1)
    ++roots_.count[__builtin_ctz(left)];
}

// Goes on with the lower halves; the upper ones wait, uncut.
void CubicLanes::halve(M where, M by_u) {
  halves_.by_count(bits_of<V>(where), [&](int number, uint32_t lanes) HWY_ATTR {
    const M mask = mask_of<V>(lanes);
    if (number == kHalvesMax) return give_up(mask);
    for (int k = 0; k < 2; ++k) {
      for (int p = 0; p < 16; ++p) store_where(mask, f_[k].x[p], halves_.rows[number][16 * k + p]);
      store_where(mask, low_[k], halves_.rows[number][32 + k]);
      store_where(mask, high_[k], halves_.rows[number][34 + k]);
    }
    halved_by_u_[number] = (halved_by_u_[number] & ~lanes) | (bits_of<V>(by_u) & lanes);
  });
  where = where && active_;
  next_[0].replace(where && by_u, set<V>(0), set<V>(0.5));
  next_[1].replace(and_not(by_u, where), set<V>(0), set<V>(0.5));
  for (uint32_t left = bits_of<V>(where); left != 0; left &= left - 1)
    ++halves_.count[__builtin_ctz(left)];
}

// Takes the last half that waits, or ends.
void CubicLanes::leave(M where) {
  uint32_t ended = 0;
  for (uint32_t left = bits_of<V>(where); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    if (--halves_.count[lane] < 0) ended |= 1u << lane;
  }
  active_ = and_not(mask_of<V>(ended), active_);
  halves_.by_count(bits_of<V>(where) & ~ended, [&](int number, uint32_t lanes) HWY_ATTR {
    const M mask = mask_of<V>(lanes), by_u = mask_of<V>(lanes & halved_by_u_[number]);
    for (int k = 0; k < 2; ++k) {
      for (int p = 0; p < 16; ++p)
        f_[k].x[p] = select(mask, load<V>(halves_.rows[number][16 * k + p]), f_[k].x[p]);
      low_[k] = select(mask, load<V>(halves_.rows[number][32 + k]), low_[k]);
      high_[k] = select(mask, load<V>(halves_.rows[number][34 + k]), high_[k]);
    }
    next_[0].replace(by_u, set<V>(0.5), set<V>(1));
    next_[1].replace(and_not(by_u, mask), set<V>(0.5), set<V>(1));
  });
}

// Newton's iteration in the box of this number of each lane.
void CubicLanes::newton(int root) {
  uint32_t lanes = 0;
  for (int lane = 0; lane < kWidth; ++lane)
    if (roots_.count[lane] > root) lanes |= 1u << lane;
  active_ = mask_of<V>(lanes & ~given_up_);
  V from[2] = {}, until[2] = {}, at[2] = {}, tolerance[2] = {}, t = set<V>(0);
  for (int k = 0; k < 2; ++k) {
    from[k] = load<V>(roots_.rows[root][k]);
    until[k] = load<V>(roots_.rows[root][2 + k]);
    at[k] = 0.5 * (from[k] + until[k]);
  }
  const LaneTriple d = points_.direction();
  const V size = max(until[0] - from[0], until[1] - from[1]), length = length_of(d);
  V last = set<V>(__builtin_inf());
  M moves = active_;
  for (int step = 0; !is_none<V>(moves); ++step) {
    const CubicLanePoints::Jet jet = points_.jet_at(at[0], at[1]);
    const LaneTriple c = cross_of(d, jet.point), n = cross_of(jet.du, jet.dv);
    const V unit = 1 / dot_of(n, d);
    give_up(moves && !(abs(unit) < set<V>(__builtin_inf())));
    moves = moves && active_;
    t = select(moves, dot_of(n, jet.point) * unit, t);
    const V moved[2] = {-dot_of(jet.dv, c) * unit, dot_of(jet.du, c) * unit};
    const V scale = 4 * noise_ * abs(unit) * length;
    tolerance[0] = select(moves, Limits::kOverlap + scale * length_of(jet.dv), tolerance[0]);
    tolerance[1] = select(moves, Limits::kOverlap + scale * length_of(jet.du), tolerance[1]);
    const V now = max(abs(moved[0]), abs(moved[1]));
    M is_last = now <= 0x1p-15 * size || now <= set<V>(0x1p-34);
    if (step > 4) is_last = is_last || now >= last;
    if (step == Limits::kNewtonStepsMax) is_last = moves;
    last = now;
    for (int k = 0; k < 2; ++k) {
      const V next = at[k] + moved[k];
      at[k] = select(moves, select(is_last, next, min(max(next, from[k]), until[k])), at[k]);
    }
    moves = and_not(is_last, moves);
  }
  M is_root = active_;
  for (int k = 0; k < 2; ++k) {
    const V slack = 0x1p-16 * size + tolerance[k];
    is_root = is_root && abs(at[k]) <= 1 + tolerance[k];
    is_root = is_root && at[k] >= from[k] - slack && at[k] <= until[k] + slack;
  }
  report(is_root, t, at[0], at[1]);
}

void CubicLanes::report(M where, V t, V x, V y) {
  const M is_in = where && t >= points_.t_min() && t <= points_.t_max();
  const M is_best = is_in && (has_hit_ == set<V>(0) || t < t_);
  has_hit_ = select(is_best, set<V>(1), has_hit_);
  t_ = select(is_best, t, t_);
  const V one = set<V>(1), low = set<V>(-1);
  u_ = select(is_best, points_.middle(0) + points_.half(0) * min(max(x, low), one), u_);
  v_ = select(is_best, points_.middle(1) + points_.half(1) * min(max(y, low), one), v_);
}

inline void solve_cubics(const PatchQuestion* questions, int count, SolvedPatch* to) {
  // Where a register has few lanes, or few are asked for, questions are solved one by one.
  constexpr int kWorthLanes = 2;
  constexpr int kWidth = CubicLanes::kWidth;
  while (count > 0) {
    const int some = min_of(count, kWidth);
    if (kWidth >= 4 && some >= kWorthLanes) {
      CubicLanes lanes;
      lanes.solve(questions, some, to);
    } else {
      for (int k = 0; k < some; ++k) {
        const PatchQuestion& q = questions[k];
        solve_cubic(*q.patch, *q.part, q.origin, q.direction, q.t_range, to[k]);
      }
    }
    questions += some;
    to += some;
    count -= some;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
