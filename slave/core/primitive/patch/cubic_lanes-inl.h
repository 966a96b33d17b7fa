// SPDX-License-Identifier: Apache-2.0
// The complete solver of cubics (cubic_solver-inl.h) for many questions at once, one in each lane
// of a register. Lanes do what it does, operation by operation, so answers have its bits. A lane
// whose boxes are all looked at takes the next question once half of the lanes are free; boxes with
// one root at most are noted for Newton's iteration, which has registers of its own
// (cubic_lane_roots-inl.h). What is seldom and long is not done here, but asked of the other solver
// from the start: many boxes, many halves, and boxes that are flat.
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
#include "slave/core/primitive/patch/cubic_lane_roots-inl.h"
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

  // Shape: questions, to [count], count from 1 to 64.
  HWY_INLINE CubicLanes(const PatchQuestion* questions, int count, SolvedPatch* to)
      : questions_(questions), count_(count), to_(to) {}
  HWY_INLINE void solve();

 private:
  static constexpr int kBoxesMax = 48;    // beyond these a lane is asked of the other solver
  static constexpr int kHalvesMax = 6;    // that wait
  static constexpr int kBoxNumbers = 36;  // of a half that waits: its nets and its limits
  static constexpr uint32_t kAll = (1u << kWidth) - 1;
  static constexpr int kWorthStepping = kWidth / 2;  // lanes, where others may take a question

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
    V change[2];  // of F' along each axis; 0 where nothing is known
    HWY_INLINE V kept(int axis) const { return 0.5 * (high[axis] - low[axis]); }
  };

  HWY_INLINE void fill();
  HWY_INLINE void end(uint32_t lanes);
  HWY_INLINE M find_square(M lanes);
  HWY_INLINE void project(M lanes);
  HWY_INLINE void cut();
  HWY_INLINE void step();
  HWY_INLINE Slopes slopes() const;
  HWY_INLINE Narrowed narrowed(const Slopes& slopes) const;
  HWY_INLINE void note(M where, const Narrowed& to);
  HWY_INLINE void halve(M where, M by_u);
  HWY_INLINE void leave(M where);
  HWY_INLINE void give_up(M where) {
    for (uint32_t left = bits_of<V>(where); left != 0; left &= left - 1)
      given_up_ |= uint64_t{1} << number_[__builtin_ctz(left)];
    active_ = and_not(where, active_);
  }
  HWY_INLINE void settle_roots() { given_up_ |= roots_.settle(questions_, to_); }

  const PatchQuestion* const questions_;
  const int count_;
  SolvedPatch* const to_;
  int next_question_ = 0;
  int number_[kWidth];     // of the question in each lane
  uint32_t taken_ = 0;     // lanes that have one
  uint64_t given_up_ = 0;  // questions
  CubicLanePoints points_;
  V noise_f_{}, flat_{};
  M active_{};                    // lanes with boxes that are not looked at yet
  V low_[2] = {}, high_[2] = {};  // of the box
  CubicLaneNet f_[2];
  LaneRange next_[2];  // of the box, what is looked at next
  V boxes_{};
  LaneNotes<kHalvesMax, kBoxNumbers> halves_;
  uint32_t halved_by_u_[kHalvesMax] = {};
  CubicLaneRoots roots_;
};

void CubicLanes::solve() {
  for (int k = 0; k < count_; ++k) to_[k] = {0, 0, 0, 0, false, false};
  active_ = mask_of<V>(0);
  for (fill(); taken_ != 0; fill()) {
    const int least = next_question_ < count_ ? kWorthStepping : 0;
    while (__builtin_popcount(bits_of<V>(active_)) > least) {
      step();
      cut();
    }
    end(taken_ & ~bits_of<V>(active_));
  }
  if (!roots_.is_empty()) settle_roots();
  for (; given_up_ != 0; given_up_ &= given_up_ - 1) {
    const int k = __builtin_ctzll(given_up_);
    const PatchQuestion& q = questions_[k];
    solve_cubic(*q.patch, *q.part, q.origin, q.direction, q.t_range, to_[k]);
  }
}

// Gives questions that wait to lanes that are free.
void CubicLanes::fill() {
  uint32_t lanes = 0;
  const bool is_first = next_question_ == 0;
  for (uint32_t left = kAll & ~taken_; left != 0 && next_question_ < count_; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    number_[lane] = next_question_++;
    lanes |= 1u << lane;
  }
  if (lanes == 0) return;
  taken_ |= lanes;
  if (is_first)  // others have the numbers of some question, too
    for (int lane = 0; lane < kWidth; ++lane)
      if ((lanes >> lane & 1) == 0) number_[lane] = 0;
  points_.load_all(questions_, number_, is_first ? kAll : lanes);
  const M are_new = mask_of<V>(is_first ? kAll : lanes);
  const M have_boxes = find_square(are_new) && mask_of<V>(lanes);
  noise_f_ = Limits::kNoiseShare * points_.far() * points_.high_w();
  flat_ = Limits::kFlat * points_.extent() * points_.low_w() + 2 * noise_f_;
  boxes_ = select(are_new, set<V>(0), boxes_);
  if (!is_none<V>(have_boxes)) project(are_new);
  active_ = active_ || have_boxes;
}

// Frees lanes whose boxes are all looked at.
void CubicLanes::end(uint32_t lanes) {
  alignas(64) double boxes[kWidth];
  store(boxes_, boxes);
  taken_ &= ~lanes;
  for (; lanes != 0; lanes &= lanes - 1) {
    const int lane = __builtin_ctz(lanes);
    to_[number_[lane]].box_count = static_cast<int>(boxes[lane]);
    halves_.count[lane] = 0;
  }
}

// Sets the first boxes of these lanes. Returns: those that have one.
CubicLanes::M CubicLanes::find_square(M lanes) {
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
    const V low = set<V>(-1 - kSquareWiden), high = set<V>(1 + kSquareWiden);
    low_[a] = select(lanes, select(has_frame && at - reach > low, at - reach, low), low_[a]);
    high_[a] = select(lanes, select(has_frame && at + reach < high, at + reach, high), high_[a]);
  }
  return low_[0] <= high_[0] && low_[1] <= high_[1];
}

// Takes F over the first boxes of these lanes.
void CubicLanes::project(M lanes) {
  const LaneTriple direction = points_.direction();
  const V x = abs(direction.x), y = abs(direction.y), z = abs(direction.z);
  const M is_y = y < x, is_z = z < min(x, y);
  const V zero = set<V>(0), one = set<V>(1);
  const LaneTriple axis{select(is_y || is_z, zero, one), select(is_y && !is_z, one, zero),
                        select(is_z, one, zero)};
  const LaneTriple d = unit_of(direction), across = unit_of(cross_of(axis, d));
  const LaneTriple n[2] = {across, cross_of(d, across)};
  CubicLaneNet f[2];
  for (int number = 0; number < 16; ++number) {
    const LaneTriple p = points_.point(number);
    for (int k = 0; k < 2; ++k) f[k].x[number] = n[k].x * p.x + n[k].y * p.y + n[k].z * p.z;
  }
  for (int a = 0; a < 2; ++a) {
    const V middle = points_.middle(a), half = points_.half(a);
    const CubicCut<V> part(middle + half * low_[a], middle + half * high_[a]);
    for (CubicLaneNet& net : f) a == 0 ? net.cut<0>(part) : net.cut<1>(part);
  }
  for (int k = 0; k < 2; ++k)
    for (int p = 0; p < 16; ++p) f_[k].x[p] = select(lanes, f[k].x[p], f_[k].x[p]);
}

// Cuts all boxes to what is looked at next.
void CubicLanes::cut() {
  for (int a = 0; a < 2; ++a) {
    const LaneRange range = next_[a];
    const M is_whole = range.from == set<V>(0) && range.to == set<V>(1);
    if (is_all<V>(is_whole)) continue;
    const CubicCut<V> part(range.from, range.to);
    for (CubicLaneNet& net : f_) a == 0 ? net.cut<0>(part) : net.cut<1>(part);
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
    const M is_equal = to.change[0] == to.change[1];
    const M by_u = to.change[0] > to.change[1] || (is_equal && of.size(0) >= of.size(1));
    if (!is_none<V>(halves)) halve(halves, by_u);
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
  Narrowed to = {
      {set<V>(-1), set<V>(-1)}, {set<V>(1), set<V>(1)}, set<V>(0), {set<V>(0), set<V>(0)}};
  for (int k = 0; k < 2; ++k) {
    const V y0 = abs(y[k][0]), y1 = abs(y[k][1]);
    to.r = max(to.r, y0 * (slopes.radius(0, 0) + slopes.radius(0, 1)) +
                         y1 * (slopes.radius(1, 0) + slopes.radius(1, 1)));
    for (int a = 0; a < 2; ++a)
      to.change[a] = max(to.change[a], y0 * slopes.radius(0, a) + y1 * slopes.radius(1, a));
    V least[4] = {}, most[4] = {};  // by the place of their axis
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const int number = k == 0 ? 4 * i + j : 4 * j + i;
        const V x = y[k][0] * f_[0].x[number] + y[k][1] * f_[1].x[number];
        least[i] = j == 0 ? x : min(least[i], x);
        most[i] = j == 0 ? x : max(most[i], x);
      }
    const V wide = (y0 + y1) * noise_f_ + Limits::kNetRoundings;
    V from = set<V>(-1), until = set<V>(1);
    for (const double share : Limits::kShares) {
      V low = {}, high = {};
      for (int i = 0; i < 4; ++i) {
        const V early = kPlace[i] - share * most[i], late = kPlace[i] - share * least[i];
        low = i == 0 ? early : min(low, early);
        high = i == 0 ? late : max(high, late);
      }
      from = max(from, low - wide);
      until = min(until, high + wide);
    }
    to.low[k] = select(is_good, from, to.low[k]);
    to.high[k] = select(is_good, until, to.high[k]);
  }
  to.r = select(is_good, to.r, set<V>(__builtin_inf()));
  for (V& change : to.change) change = select(is_good, change, set<V>(0));
  return to;
}

// Notes what may hold a root, for Newton's iteration.
void CubicLanes::note(M where, const Narrowed& to) {
  alignas(64) double from[2][kWidth], until[2][kWidth];
  for (int k = 0; k < 2; ++k) {
    const V middle = 0.5 * (low_[k] + high_[k]), half = 0.5 * (high_[k] - low_[k]);
    store(middle + half * to.low[k], from[k]);
    store(middle + half * to.high[k], until[k]);
  }
  for (uint32_t left = bits_of<V>(where); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    if (roots_.is_full()) settle_roots();
    roots_.note(number_[lane], {from[0][lane], from[1][lane]}, {until[0][lane], until[1][lane]});
  }
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

inline void solve_cubics(const PatchQuestion* questions, int count, SolvedPatch* to) {
  // Where a register has few lanes, or few are asked for, questions are solved one by one.
  constexpr int kWorthLanes = 2, kMost = 64;
  while (count > 0) {
    const int some = min_of(count, kMost);
    if (CubicLanes::kWidth >= 4 && some >= kWorthLanes) {
      CubicLanes(questions, some, to).solve();
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
