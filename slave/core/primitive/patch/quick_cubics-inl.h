// SPDX-License-Identifier: Apache-2.0
// What can be answered of questions to the complete solver without it: a filter in float32, one
// question's box in each lane of a register, for polynomial bicubic sub-patches. It proves that a
// ray misses, or that there is one root at most in a box, which quick_roots-inl.h then ends in
// double; all else stays open. Answers are those of the complete solver, to the bit.
//
// Method. F is the surface seen along the ray, in the frame of its sub-patch
// (patch_decision-inl.h), as two nets of Bernstein coefficients over a box. With Y the inverse of
// the mean of F' over the box, H = Y F is about the box's own square [-1, 1]^2.
// 1. 0 outside of the range of H's coefficients: there is no root (R. Farouki, V. Rajan, "On the
//    numerical condition of polynomials in Bernstein form", CAGD 4, 1987, for the hull).
// 2. Narrowing as in cubic_solver-inl.h, with two shares.
// 3. One root at most: for two points p, q of the box, H(p) - H(q) = A (p - q), each row of A a
//    mean of that row of H', hence within the ranges of differences of coefficients. If a, b > 0
//    are the least of H_1x and H_2y, c, d the most of |H_1y| and |H_2x|, and a b > c d, then det A
//    > 0 and H(p) = H(q) only for p = q.
// 4. A box that has one root at most, and which narrowing leaves away from the square's border, is
//    noted. One that narrows little is halved along the axis along which H' changes more.
// Questions do not wait for each other: all boxes stand in one row, a register full is looked at,
// and what is left of them is put at the end, side by side. The net of a box is cut from that of
// its question each time, so that roundings do not add up from look to look.
//
// Roundings, u = 2^-24. With N = |f_k| + |p| |f_n|, R the largest coordinate of P - C and S = N R +
// |at|: rounding P - C, its products with f_k and their sums make 4 u |f_k| R, those with f_n are
// alike. Rounding p, the difference, the place and what is left of it makes it below 8 u S; the
// place is taken in double, 2^-45 N |O - C|. A cut has weights good to 8 u, which have the sum 1
// and are negative only by as much as a box reaches beyond the patch, below 2^-11, and sums of
// four: 12 u of the largest coefficient, twice. Y F adds 2 u. So nets are off by less than 35 u S,
// for which `noise` has 48 u. Differences have twice the noise, and one rounding.
// Limits of boxes are moved out by 2^-20 of them for theirs. In the patch's square they are a sum
// of numbers that are rounded, below 1 and a little, and rounded again when moved: 4 u, for which
// kPlacesOff has 8 u; those of the first box have 2 u for it. So the box to which a net is cut,
// which is exactly its limits in float32, has all roots that the one before had.
//
// Threads. One call owns one.
#include "slave/core/primitive/patch/cubic_solver_layout.h"

#if defined(TESSERA_CORE_QUICK_CUBICS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_QUICK_CUBICS_INL_H_
#undef TESSERA_CORE_QUICK_CUBICS_INL_H_
#else
#define TESSERA_CORE_QUICK_CUBICS_INL_H_
#endif

#include "slave/core/primitive/patch/quick_boxes-inl.h"
#include "slave/core/primitive/patch/quick_roots-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

class QuickCubics {
  using V = Floats;
  using M = MaskOf<V>;

 public:
  // Shape: questions, to [count].
  HWY_INLINE QuickCubics(const PatchQuestion* questions, int count, QuickAnswer* to)
      : questions_(questions), count_(count), to_(to) {}
  HWY_INLINE void answer();

 private:
  static constexpr int kWidth = static_cast<int>(kLaneCount);
  static constexpr float kNarrow = 0.8f;     // of a side, where a box need not be halved
  static constexpr float kNarrowEnd = 0.5f;  // of both sides, where it may be noted
  static constexpr float kBorder = 1 - 0x1p-9f;
  static constexpr float kSmall = 0x1p-9f;       // a box at the border is noted all the same
  static constexpr float kPlacesOff = 0x1p-21f;  // of limits in the patch's square
  // A box is as old as the looks it took, halvings four times, all that lead to it. Beyond that
  // questions stay open.
  static constexpr float kOld = 16;

  // The part of a box that may have roots, in the box's square.
  struct Narrowed {
    V low[2], high[2];
    M is_empty;
    HWY_INLINE V kept(int axis) const { return 0.5f * (high[axis] - low[axis]); }
  };
  // How H' is over a box, times 2/3.
  struct Slopes {
    V along[2], aside[2];  // the least of H_1x, H_2y; the most of |H_1y|, |H_2x|
  };

  HWY_INLINE void look();
  static HWY_INLINE M precondition(QuickBox& box, V (&noise)[2]);
  static HWY_INLINE Narrowed narrowed(const QuickBox& box, const V (&of_net)[2], M is_good);
  static HWY_INLINE Slopes slopes(const QuickBox& box);
  HWY_INLINE void give_up(M lanes, const QuickBox& box, const V (&guess)[2]);
  HWY_INLINE void leave_open(M lanes, V number);

  const PatchQuestion* const questions_;
  const int count_;
  bool is_any_ = true;  // any hit will do for all questions
  QuickAnswer* const to_;
  uint64_t open_ = 0;  // bits of questions
  QuickBoxes boxes_;
  QuickRoots roots_;
};

void QuickCubics::answer() {
  for (int k = 0; k < count_; ++k) {
    to_[k] = {false, false, 0};
    is_any_ &= questions_[k].is_any;
  }
  for (int next = 0; next < count_ || !boxes_.is_empty();) {
    while (boxes_.count() < kWidth && next < count_) {
      const int some = min_of(count_ - next, kWidth);
      boxes_.put_first(questions_, next, some);
      next += some;
    }
    if (!boxes_.is_empty()) look();
    while (roots_.is_enough()) open_ |= roots_.settle(questions_, to_);
  }
  if (!roots_.is_empty()) open_ |= roots_.settle(questions_, to_);
  for (int k = 0; k < count_; ++k)
    to_[k].is_known = (open_ >> k & 1) == 0 || (questions_[k].is_any && to_[k].is_hit);
}

// Looks at the next boxes.
void QuickCubics::look() {
  QuickBox box;
  const M active = boxes_.take(box);
  V noise[2] = {};
  const M is_good = precondition(box, noise);
  const Narrowed to = narrowed(box, noise, is_good);
  const Slopes of = slopes(box);
  M goes_on = and_not(to.is_empty, active);

  const V zero = set<V>(0);
  V least[2] = {}, most[2] = {};
  for (int k = 0; k < 2; ++k) {
    least[k] = of.along[k] - 3 * noise[k];
    most[k] = of.aside[k] + 3 * noise[k];
  }
  const M is_single = is_good && least[0] > zero && least[1] > zero &&
                      least[0] * least[1] > most[0] * most[1] * (1 + 0x1p-18f);
  V low[2] = {}, high[2] = {}, guess[2] = {};
  M is_near = and_not(active, active), is_wide = is_near;
  for (int a = 0; a < 2; ++a) {
    const V half = 0.5f * (box.high[a] - box.low[a]), middle = 0.5f * (box.high[a] + box.low[a]);
    low[a] = mul_add(half, to.low[a], middle);
    high[a] = mul_add(half, to.high[a], middle);
    guess[a] = 0.25f * mul_add(box.until[a] - box.from[a], to.low[a] + to.high[a],
                               2 * (box.until[a] + box.from[a]));
    is_near = is_near || max(high[a], -low[a]) > set<V>(kBorder);
    is_wide = is_wide || high[a] - low[a] > set<V>(kSmall);
  }
  const M ends = goes_on && is_single && max(to.kept(0), to.kept(1)) < set<V>(kNarrowEnd) &&
                 !(is_near && is_wide);
  if (!is_none<V>(ends)) roots_.put(ends, box.number, box.from, box.until, guess, true);
  goes_on = and_not(ends, goes_on);
  M halves = and_not(is_single, goes_on) && !(min(to.kept(0), to.kept(1)) < set<V>(kNarrow));
  box.age = box.age + select(halves, set<V>(4), set<V>(1));
  const M is_old = goes_on && box.age > set<V>(kOld);
  if (!is_none<V>(is_old)) give_up(is_old, box, guess);
  goes_on = and_not(is_old, goes_on);
  halves = and_not(is_old, halves);
  if (is_none<V>(goes_on)) return;
  if (!boxes_.has_room()) return leave_open(goes_on, box.number);
  for (int a = 0; a < 2; ++a) {
    box.low[a] = low[a];
    box.high[a] = high[a];
    const V half = 0.5f * (box.until[a] - box.from[a]);
    const V middle = 0.5f * (box.until[a] + box.from[a]);
    box.from[a] = mul_add(half, to.low[a], middle) - kPlacesOff;
    box.until[a] = mul_add(half, to.high[a], middle) + kPlacesOff;
  }
  const V change[2] = {max(1 - 1.5f * of.along[0], 1.5f * of.aside[1]),
                       max(1 - 1.5f * of.along[1], 1.5f * of.aside[0])};
  boxes_.put(box, goes_on, halves, change[0] >= change[1]);
}

// The net of F becomes that of H, which is off by `noise`. Returns: where F' has an inverse;
// elsewhere H is F.
QuickCubics::M QuickCubics::precondition(QuickBox& box, V (&noise)[2]) {
  V mean[2][2] = {};
  for (int k = 0; k < 2; ++k) {
    const V(&x)[16] = box.net[k];
    const V forth = x[15] - x[0], aside = x[12] - x[3];
    mean[k][0] = 0.25f * (forth + aside);
    mean[k][1] = 0.25f * (forth - aside);
  }
  const V one = set<V>(1);
  const V unit = 1 / (mean[0][0] * mean[1][1] - mean[0][1] * mean[1][0]);
  const M is_good = abs(unit) < set<V>(0x1p100f);
  const V y[2][2] = {
      {select(is_good, mean[1][1] * unit, one), zero_unless(is_good, -mean[0][1] * unit)},
      {zero_unless(is_good, -mean[1][0] * unit), select(is_good, mean[0][0] * unit, one)}};
  for (int n = 0; n < 16; ++n) {
    const V f[2] = {box.net[0][n], box.net[1][n]};
    for (int k = 0; k < 2; ++k) box.net[k][n] = mul_add(y[k][0], f[0], y[k][1] * f[1]);
  }
  for (int k = 0; k < 2; ++k)
    noise[k] = mul_add(abs(y[k][0]), box.noise[0], abs(y[k][1]) * box.noise[1]);
  return is_good;
}

QuickCubics::Narrowed QuickCubics::narrowed(const QuickBox& box, const V (&of_net)[2], M is_good) {
  constexpr float kPlace[4] = {-1, 2.0f / 3 - 1, 4.0f / 3 - 1, 1};
  const V one = set<V>(1);
  Narrowed to;
  to.is_empty = and_not(is_good, is_good);
  for (int k = 0; k < 2; ++k) {
    V least[4] = {}, most[4] = {};  // by the place of their axis
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const V x = box.net[k][k == 0 ? 4 * i + j : 4 * j + i];
        least[i] = j == 0 ? x : min(least[i], x);
        most[i] = j == 0 ? x : max(most[i], x);
      }
    const V low = min(min(least[0], least[1]), min(least[2], least[3]));
    const V high = max(max(most[0], most[1]), max(most[2], most[3]));
    const V noise = of_net[k], wide = noise + 0x1p-20f;
    V from = -one, until = one;
    for (const float share : {1.0f, 0.3f}) {
      V early = {}, late = {};
      for (int i = 0; i < 4; ++i) {
        const V e = neg_mul_add(set<V>(share), most[i], set<V>(kPlace[i]));
        const V l = neg_mul_add(set<V>(share), least[i], set<V>(kPlace[i]));
        early = i == 0 ? e : min(early, e);
        late = i == 0 ? l : max(late, l);
      }
      from = max(from, early - wide);
      until = min(until, late + wide);
    }
    to.low[k] = select(is_good, from, -one);
    to.high[k] = select(is_good, until, one);
    to.is_empty = to.is_empty || low > noise || high < -noise || to.low[k] > to.high[k];
  }
  return to;
}

QuickCubics::Slopes QuickCubics::slopes(const QuickBox& box) {
  Slopes of;
  for (int k = 0; k < 2; ++k) {
    const V(&x)[16] = box.net[k];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) {
        const V by_x = x[4 * i + 4 + j] - x[4 * i + j], by_y = x[4 * j + i + 1] - x[4 * j + i];
        const V along = k == 0 ? by_x : by_y, aside = abs(k == 0 ? by_y : by_x);
        const bool is_first = i == 0 && j == 0;
        of.along[k] = is_first ? along : min(of.along[k], along);
        of.aside[k] = is_first ? aside : max(of.aside[k], aside);
      }
  }
  return of;
}

// Looks no longer at these boxes. Where any hit will do, one may still be found in them.
void QuickCubics::give_up(M lanes, const QuickBox& box, const V (&guess)[2]) {
  if (!is_any_) return leave_open(lanes, box.number);
  while (roots_.is_enough()) open_ |= roots_.settle(questions_, to_);
  roots_.put(lanes, box.number, box.from, box.until, guess, false);
}

void QuickCubics::leave_open(M lanes, V number) {
  alignas(64) float numbers[kWidth];
  store(number, numbers);
  for (uint32_t left = bits_of<V>(lanes); left != 0; left &= left - 1)
    open_ |= uint64_t{1} << static_cast<int>(numbers[__builtin_ctz(left)]);
}

// As QuickAnswersCall says.
inline void quick_answers(const PatchQuestion* questions, int count, QuickAnswer* to) {
  QuickCubics(questions, count, to).answer();
}

#else

inline void quick_answers(const PatchQuestion*, int count, QuickAnswer* to) {
  for (int k = 0; k < count; ++k) to[k] = {false, false, 0};
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
