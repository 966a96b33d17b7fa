// SPDX-License-Identifier: Apache-2.0
// Boxes with one root at most, which Newton's iteration ends, a register of them at once. Lanes do
// what CubicSolver::newton() does, operation by operation.
//
// Threads. One call of a solver owns one.
#include "slave/core/primitive/patch/cubic_solver_layout.h"

#if defined(TESSERA_CORE_CUBIC_LANE_ROOTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_CUBIC_LANE_ROOTS_INL_H_
#undef TESSERA_CORE_CUBIC_LANE_ROOTS_INL_H_
#else
#define TESSERA_CORE_CUBIC_LANE_ROOTS_INL_H_
#endif

#include "slave/core/primitive/patch/cubic_lane_points-inl.h"
#include "slave/core/primitive/patch/cubic_solver-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class CubicLaneRoots {
  using V = Doubles;
  using M = MaskOf<V>;
  using Limits = CubicSolverLimits;

 public:
  static constexpr int kWidth = CubicLanePoints::kWidth;

  // Requires: !is_full().
  HWY_INLINE void note(int question, const double (&from)[2], const double (&until)[2]) {
    question_[count_] = question;
    for (int k = 0; k < 2; ++k) {
      from_[k][count_] = from[k];
      until_[k][count_] = until[k];
    }
    ++count_;
  }
  HWY_INLINE bool is_empty() const { return count_ == 0; }
  HWY_INLINE bool is_full() const { return count_ == kWidth; }

  // Looks at all that were noted, in their order, and forgets them.
  // Returns: bits of the questions that are to be asked of the other solver.
  HWY_NOINLINE uint64_t settle(const PatchQuestion* questions, SolvedPatch* to);

 private:
  // Where the iterations end; `is_root` is false where they leave the box or the square.
  struct Ends {
    V t, at[2];
    M is_root, is_given_up;
  };
  HWY_INLINE Ends run(M lanes) const;

  CubicLanePoints points_;
  int count_ = 0;
  int question_[kWidth];
  alignas(64) double from_[2][kWidth] = {}, until_[2][kWidth] = {};
};

uint64_t CubicLaneRoots::settle(const PatchQuestion* questions, SolvedPatch* to) {
  const uint32_t lanes = (1u << count_) - 1;
  for (int lane = count_; lane < kWidth; ++lane) question_[lane] = question_[0];
  points_.load_all(questions, question_, (1u << kWidth) - 1);
  const Ends ends = run(mask_of<V>(lanes));
  alignas(64) double t[kWidth], at[2][kWidth];
  store(ends.t, t);
  for (int k = 0; k < 2; ++k) {
    const V within = min(max(ends.at[k], set<V>(-1)), set<V>(1));
    store(points_.middle(k) + points_.half(k) * within, at[k]);
  }
  for (uint32_t left = bits_of<V>(ends.is_root) & lanes; left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    const PatchQuestion& question = questions[question_[lane]];
    SolvedPatch& best = to[question_[lane]];
    if (!(t[lane] >= static_cast<double>(question.t_range[0]) &&
          t[lane] <= static_cast<double>(question.t_range[1])))
      continue;
    if (best.is_hit && !(t[lane] < best.t)) continue;
    best.is_hit = true;
    best.t = t[lane];
    best.u = at[0][lane];
    best.v = at[1][lane];
  }
  uint64_t given_up = 0;
  for (uint32_t left = bits_of<V>(ends.is_given_up) & lanes; left != 0; left &= left - 1)
    given_up |= uint64_t{1} << question_[__builtin_ctz(left)];
  count_ = 0;
  return given_up;
}

CubicLaneRoots::Ends CubicLaneRoots::run(M lanes) const {
  V from[2] = {}, until[2] = {}, at[2] = {}, tolerance[2] = {}, t = set<V>(0);
  for (int k = 0; k < 2; ++k) {
    from[k] = load<V>(from_[k]);
    until[k] = load<V>(until_[k]);
    at[k] = 0.5 * (from[k] + until[k]);
  }
  const LaneTriple d = points_.direction();
  const V noise = Limits::kEvaluation * points_.far();
  const V size = max(until[0] - from[0], until[1] - from[1]), length = length_of(d);
  V last = set<V>(__builtin_inf());
  M moves = lanes, is_given_up = and_not(lanes, lanes);
  for (int step = 0; !is_none<V>(moves); ++step) {
    const CubicLanePoints::Jet jet = points_.jet_at(at[0], at[1]);
    const LaneTriple c = cross_of(d, jet.point), n = cross_of(jet.du, jet.dv);
    const V unit = 1 / dot_of(n, d);
    const M is_finite = abs(unit) < set<V>(__builtin_inf());
    is_given_up = is_given_up || and_not(is_finite, moves);
    moves = moves && is_finite;
    t = select(moves, dot_of(n, jet.point) * unit, t);
    const V moved[2] = {-dot_of(jet.dv, c) * unit, dot_of(jet.du, c) * unit};
    const V scale = 4 * noise * abs(unit) * length;
    tolerance[0] = select(moves, Limits::kOverlap + scale * length_of(jet.dv), tolerance[0]);
    tolerance[1] = select(moves, Limits::kOverlap + scale * length_of(jet.du), tolerance[1]);
    const V now = max(abs(moved[0]), abs(moved[1]));
    M is_last = now <= Limits::kLastStep * size || now <= set<V>(0x1p-34);
    if (step > 4) is_last = is_last || now >= last;
    if (step == Limits::kNewtonStepsMax) is_last = moves;
    last = now;
    for (int k = 0; k < 2; ++k) {
      const V next = at[k] + moved[k];
      at[k] = select(moves, select(is_last, next, min(max(next, from[k]), until[k])), at[k]);
    }
    moves = and_not(is_last, moves);
  }
  M is_root = and_not(is_given_up, lanes);
  for (int k = 0; k < 2; ++k) {
    const V slack = 0x1p-16 * size + tolerance[k];
    is_root = is_root && abs(at[k]) <= 1 + tolerance[k];
    is_root = is_root && at[k] >= from[k] - slack && at[k] <= until[k] + slack;
  }
  return {t, {at[0], at[1]}, is_root, is_given_up};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
