// SPDX-License-Identifier: Apache-2.0
// The usual decision: whether and where a ray meets a sub-patch, as one sequence of double
// operations for each (ray, sub-patch). T: double, or a register of doubles; lanes never look at
// each other, so the bits are the same. It proves what it says, or leaves the ray undecided.
//
// In the frame the ray runs along (p, q) = (d_a, d_b) / d_n. Seen along the ray,
//   F(x, y) = (S_a - o_a - p (S_n - o_n), S_b - o_b - q (S_n - o_n)).
// 1. Roots. S = (x, y, 0) + rest on the ray means x = (o_a - p o_n) + p rest_n - rest_a, so all
//    roots lie within reach_a + |p| reach_n of x_0 = o_a - p o_n, and so by y. A box that does not
//    meet the square is a miss. d_n = 0 gives NaN or infinities, for which every comparison says
//    "open": the ray is undecided.
// 2. Uniqueness. S and its derivatives are taken at the middle of what box and square share, half
//    widths (rx, ry); Y is the inverse of F' there. B_k = B_xx rx^2 + 2 B_xy rx ry + B_yy ry^2 with
//    B.. = second_a + |p| second_n bounds what F_k's derivatives change by over the box, weighted;
//    r = max((|Y_11| B_1 + |Y_12| B_2) / rx, (|Y_21| B_1 + |Y_22| B_2) / ry) bounds |1 - Y F'| in
//    the norm max(|x| / rx, |y| / ry). r < 1: there is one root at most (R. Krawczyk,
//    "Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken", Computing 4, 1969;
//    R. Moore, "A test for existence of solutions to nonlinear systems", SIAM J. Numer. Anal. 14,
//    1977). The norm scaled by (rx, ry) is what lets long thin boxes be proved.
// 3. Narrowing. Where r > 3/4, the root is within (|Y_11| B_1 + |Y_12| B_2) / 2 of Newton's next
//    point, by x, and so by y (Krawczyk's operator): a smaller box, at most kPatchNarrowingsMax
//    times.
// 4. Newton, clamped to the box. With e_k the distance from the root in that norm, e_1 <= r / 2 and
//    e_{k+1} <= r e_k^2 / (2 (1 - r)), since (Y F'(x_k))^-1 is at most 1 / (1 - r), and clamping to
//    a box that holds the root does not increase e. r = 3/4 gives .38, .21, .066, .0066, 6.5e-5,
//    6.3e-9, 6e-17: 7 steps at most, so kPatchStepsMax = 12 never ends a ray that has a root.
// 5. Miss by proof. Were there a root, it would be within e_k of the k-th point; a point that is
//    farther than that out of the square ends the ray.
// 6. End. With s the size of a step in the norm, s <= 2^-8, and e <= s / (1 - r e / (2 (1 - r))),
//    what is left after it is at most r s^2 (2 + 2^-4). The iteration ends where that is below
//    kPatchStep of the square's half; t is of the last linear step, whose error is of second order
//    as well. After such a step F is below r s^2 / 2 in the norm, 2^-27 of the part's size, whether
//    or not the proof had a root to find: a hit is always nearer to the ray than float32 can tell.
// 7. Borders. The root is accepted where |x|, |y| <= 1 + tolerance, with tolerance =
//    kPatchOverlap + 4 |Y| (norms of the frame's rows) noise: kPatchOverlap = 4 kPatchStep covers
//    the iteration's end in both neighbours, the rest what roundings move the root by. An exact
//    root lies in some closed range, whose sub-patch therefore accepts it. Both neighbours may: the
//    nearer t wins, then the lower number. Ranges are closed across patches as well: those that
//    share control points share the border as a curve, and nothing of the neighbour is needed. A
//    tolerance above half of kSquareWiden, at silhouettes alone, leaves the ray undecided.
//
// Noise. local_points() subtracts the centre first, by exact products, so that errors are relative
// to what is looked at, R = |O - centre| + 2 (extent of the control points) by the largest axis,
// wherever in the world the patch lies: evaluation has 2^7 roundings (bernstein-inl.h), frame and
// ray at most 2^3 more of norms of the frame's rows times R. p is off by 2^-50 (N_a + |p| N_n)
// |D| / |d_n|, N the norms; at a root that is multiplied with S_n - o_n = t d_n, hence by
// |t D| <= 2 R. Altogether F is off by at most (N_a + |p| N_n) noise with noise = 2^-46 R; where
// boxes are cut, 8 times that stands.
//
// Threads. Pure functions.
#if defined(TESSERA_CORE_PATCH_DECISION_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PATCH_DECISION_INL_H_
#undef TESSERA_CORE_PATCH_DECISION_INL_H_
#else
#define TESSERA_CORE_PATCH_DECISION_INL_H_
#endif

#include "slave/core/primitive/patch/bernstein-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

inline constexpr double kPatchContraction = 0.75;  // r up to which a box is proved
inline constexpr double kPatchStep = 0x1p-26;      // error of x, y at the end
inline constexpr double kPatchOverlap = 0x1p-24;   // of ranges, in x, y
inline constexpr double kPatchEdge = 1 + kSquareWiden;
inline constexpr int kPatchStepsMax = 12;
inline constexpr int kPatchNarrowingsMax = 3;
inline constexpr double kPatchNarrowingMax = 4;     // r above which no narrower box is tried
inline constexpr double kPatchShrink = 0.75;        // of the area, for a narrower box to be tried
inline constexpr double kPatchLeastHalf = 0x1p-22;  // of a box: within kSquareWiden

// Second derivatives of a sub-patch, weighted as B_k of the whole square is (step 2), from which on
// the decision is not asked: it would leave nine of ten rays undecided.
inline constexpr float kPatchBendMax = 4;

// Whether rays are left to the complete solver without a decision: sub-patches that bend much, of
// degrees for which it is fast. Requires: it has a frame, and is no span of a widened border.
TESSERA_INLINE bool is_left_to_solver(const Patch& patch, const SubPatch& part) {
  if (patch.degree_u > 3 || patch.degree_v > 3) return false;
  const float bend_x = part.second[0][0] + 2 * part.second[1][0] + part.second[2][0];
  const float bend_y = part.second[0][1] + 2 * part.second[1][1] + part.second[2][1];
  return bend_x > kPatchBendMax || bend_y > kPatchBendMax;
}

template <class T>
struct PatchDecision {
  MaskOf<T> is_undecided, is_hit;
  T t, u, v;  // of hits
};

// Control points in the frame, frame (w P - centre w), w: the first part of the decision, once for
// all rays that ask for the sub-patch. Shape: local [(degree_u + 1) (degree_v + 1)].
TESSERA_INLINE void local_points(const SubPatch& part, const Patch& patch, PatchPoint* local) {
  const int count = (patch.degree_u + 1) * (patch.degree_v + 1);
  for (int k = 0; k < count; ++k) {
    const PatchPoint p = point_of(patch, k);
    const double w = p.x[3];
    const double x = p.x[0] - static_cast<double>(part.centre[0]) * w;
    const double y = p.x[1] - static_cast<double>(part.centre[1]) * w;
    const double z = p.x[2] - static_cast<double>(part.centre[2]) * w;
    for (int r = 0; r < 3; ++r)
      local[k].x[r] = static_cast<double>(part.frame[r][0]) * x +
                      static_cast<double>(part.frame[r][1]) * y +
                      static_cast<double>(part.frame[r][2]) * z;
    local[k].x[3] = w;
  }
}

// What is known of a sub-patch. N: double where it is one for all lanes, or T.
template <class N>
struct PartNumbers {
  N frame[3][3], centre[3], reach[3], second[3][3];
  N extent;  // of the patch's control points, the largest axis of their box
  N half_u, half_v, middle_u, middle_v;
};
TESSERA_INLINE PartNumbers<double> numbers_of(const SubPatch& part, double extent) {
  PartNumbers<double> to;
  for (int r = 0; r < 3; ++r) {
    to.centre[r] = static_cast<double>(part.centre[r]);
    to.reach[r] = static_cast<double>(part.reach[r]);
    for (int k = 0; k < 3; ++k) {
      to.frame[r][k] = static_cast<double>(part.frame[r][k]);
      to.second[r][k] = static_cast<double>(part.second[r][k]);
    }
  }
  to.extent = extent;
  to.half_u = 1.0 / (2u << part.level_u);
  to.half_v = 1.0 / (2u << part.level_v);
  to.middle_u = (2 * part.column + 1) * to.half_u;
  to.middle_v = (2 * part.row + 1) * to.half_v;
  return to;
}

// A ray in the frame of a sub-patch, and F with its derivatives and bounds.
template <class T, class N>
class RayInFrame {
 public:
  // F and F' at (x, y), t and the next point by the linear step. y..: |inverse of F'|.
  struct Step {
    T dx, dy, t, y11, y12, y21, y22;
  };

  TESSERA_INLINE RayInFrame(const PartNumbers<N>& part, const T (&origin)[3],
                            const T (&direction)[3])
      : part_(part) {
    T d[3] = {}, far = set<T>(0);
    for (int k = 0; k < 3; ++k) far = max(far, abs(origin[k] - part.centre[k]));
    noise_ = (far + 2 * part.extent) * kEvaluationError;
    for (int r = 0; r < 3; ++r) {
      const N f0 = part.frame[r][0], f1 = part.frame[r][1], f2 = part.frame[r][2];
      o_[r] = f0 * (origin[0] - part.centre[0]) + f1 * (origin[1] - part.centre[1]) +
              f2 * (origin[2] - part.centre[2]);
      d[r] = f0 * direction[0] + f1 * direction[1] + f2 * direction[2];
      norm_[r] = size_of_number(f0) + size_of_number(f1) + size_of_number(f2);
    }
    inverse_ = 1 / d[2];
    for (int c = 0; c < 2; ++c) {
      slope_[c] = d[c] * inverse_;
      size_[c] = abs(slope_[c]);
      off_[c] = (norm_[c] + size_[c] * norm_[2]) * noise_;
    }
  }

  // Where the ray passes n = 0, by x or y, and how far from it all roots are.
  TESSERA_INLINE T at(int c) const { return o_[c] - o_[2] * slope_[c]; }
  TESSERA_INLINE T reach(int c) const {
    return part_.reach[c] + size_[c] * part_.reach[2] + 8 * off_[c];
  }

  // Requires: `jet` of local points.
  TESSERA_INLINE Step step(const PatchJet<T>& jet) const {
    T w[3] = {}, lx[3] = {}, ly[3] = {};
    for (int k = 0; k < 3; ++k) {
      w[k] = jet.point[k] - o_[k];
      lx[k] = jet.du[k] * part_.half_u;
      ly[k] = jet.dv[k] * part_.half_v;
    }
    const T f = w[0] - slope_[0] * w[2], g = w[1] - slope_[1] * w[2];
    const T fx = lx[0] - slope_[0] * lx[2], fy = ly[0] - slope_[0] * ly[2];
    const T gx = lx[1] - slope_[1] * lx[2], gy = ly[1] - slope_[1] * ly[2];
    const T unit = 1 / (fx * gy - fy * gx), size = abs(unit);
    const T dx = (fy * g - gy * f) * unit, dy = (gx * f - fx * g) * unit;
    const T t = (w[2] + lx[2] * dx + ly[2] * dy) * inverse_;
    return {dx, dy, t, abs(gy) * size, abs(fy) * size, abs(gx) * size, abs(fx) * size};
  }

  // B_k of a box of half widths rx, ry.
  TESSERA_INLINE T bend(int c, T rx, T ry) const {
    return weighted(c, rx, ry) + size_[c] * weighted(2, rx, ry);
  }
  // What F is off by.
  TESSERA_INLINE T off(int c) const { return off_[c]; }

 private:
  TESSERA_INLINE T weighted(int c, T rx, T ry) const {
    return rx * (rx * part_.second[0][c] + ry * (2 * part_.second[1][c])) +
           ry * ry * part_.second[2][c];
  }

  static TESSERA_INLINE double size_of_number(double x) { return __builtin_fabs(x); }
  template <class V>
  static TESSERA_INLINE V size_of_number(V x) {
    return abs(x);
  }

  const PartNumbers<N>& part_;
  N norm_[3] = {};
  T noise_{}, inverse_{}, o_[3] = {}, slope_[2] = {}, size_[2] = {}, off_[2] = {};
};

// One interval of x or y, and its half width.
template <class T>
struct PatchSide {
  T low, high, half;

  TESSERA_INLINE PatchSide(T from, T to)
      : low(from), high(to), half(max((to - from) * 0.5, kPatchLeastHalf)) {}
  TESSERA_INLINE T middle() const { return (low + high) * 0.5; }
  TESSERA_INLINE T clamped(T x) const { return min(max(x, low), high); }
  template <class M>
  TESSERA_INLINE void replace(M mask, PatchSide other) {
    low = select(mask, other.low, low);
    high = select(mask, other.high, high);
    half = select(mask, other.half, half);
  }
};

// The state of a decision: a box, a point in it, what is known.
template <class T, class N>
class PatchDecider {
 public:
  using Mask = MaskOf<T>;
  using Ray = RayInFrame<T, N>;

  TESSERA_INLINE explicit PatchDecider(const Ray& ray)
      : ray_(ray),
        box_{whole(0), whole(1)},
        at_{box_[0].middle(), box_[1].middle()},
        is_active_(box_[0].low <= box_[0].high && box_[1].low <= box_[1].high),
        is_proved_(at_[0] != at_[0]),  // none: what is at a box is a number
        is_undecided_(is_proved_),
        is_done_(is_proved_) {}

  TESSERA_INLINE Mask is_active() const { return is_active_; }
  TESSERA_INLINE T at(int c) const { return at_[c]; }

  // Looks at the step from the present point, proves or narrows the box, and moves on.
  TESSERA_INLINE void take(const typename Ray::Step& step, bool may_narrow) {
    near_ = growth_ * near_ * near_;
    const Mask is_open = is_active_ && !is_proved_;
    if (!is_none<T>(is_open)) look(step, is_open, may_narrow);
    move(step);
  }

  TESSERA_INLINE PatchDecision<T> answer(const PartNumbers<N>& part) const {
    const Mask is_hit = is_done_ && is_inside(0) && is_inside(1);
    const T x = min(max(at_[0], -1), 1), y = min(max(at_[1], -1), 1);
    return {is_undecided_, is_hit, t_, part.middle_u + part.half_u * x,
            part.middle_v + part.half_v * y};
  }

 private:
  TESSERA_INLINE PatchSide<T> whole(int c) const {
    const T at = ray_.at(c), reach = ray_.reach(c);
    return {max(at - reach, -kPatchEdge), min(at + reach, kPatchEdge)};
  }
  TESSERA_INLINE Mask is_inside(int c) const { return abs(at_[c]) <= 1 + tolerance_[c]; }

  TESSERA_INLINE void look(const typename Ray::Step& step, Mask is_open, bool may_narrow) {
    const T bend_f = ray_.bend(0, box_[0].half, box_[1].half);
    const T bend_g = ray_.bend(1, box_[0].half, box_[1].half);
    const T change[2] = {step.y11 * bend_f + step.y12 * bend_g,
                         step.y21 * bend_f + step.y22 * bend_g};
    const T r = max(change[0] / box_[0].half, change[1] / box_[1].half);
    const T slack[2] = {kPatchOverlap + 4 * (step.y11 * ray_.off(0) + step.y12 * ray_.off(1)),
                        kPatchOverlap + 4 * (step.y21 * ray_.off(0) + step.y22 * ray_.off(1))};
    const Mask is_sharp = slack[0] <= kSquareWiden / 2 && slack[1] <= kSquareWiden / 2;
    const Mask is_good = is_open && is_sharp && r <= kPatchContraction;
    for (int c = 0; c < 2; ++c) tolerance_[c] = select(is_good, slack[c], tolerance_[c]);
    left_ = select(is_good, r * 2.0625, left_);
    near_ = select(is_good, r * 0.5, near_);
    growth_ = select(is_good, (r * 0.5) / (1 - r), growth_);
    is_proved_ = is_proved_ || is_good;
    const Mask is_bad = is_open && !is_good;
    if (!is_none<T>(is_bad)) narrow(step, change, slack, r, is_bad && is_sharp, is_bad, may_narrow);
  }

  TESSERA_INLINE void narrow(const typename Ray::Step& step, const T (&change)[2],
                             const T (&slack)[2], T r, Mask is_sharp, Mask is_bad,
                             bool may_narrow) {
    const PatchSide<T> smaller[2] = {narrowed(0, at_[0] + step.dx, 0.5 * change[0] + slack[0]),
                                     narrowed(1, at_[1] + step.dy, 0.5 * change[1] + slack[1])};
    const Mask is_empty =
        is_bad && (smaller[0].low > smaller[0].high || smaller[1].low > smaller[1].high);
    const T area = (smaller[0].high - smaller[0].low) * (smaller[1].high - smaller[1].low);
    const T old_area = (box_[0].high - box_[0].low) * (box_[1].high - box_[1].low);
    const Mask goes_on = is_sharp && !is_empty && r <= (may_narrow ? kPatchNarrowingMax : -1.0) &&
                         area <= kPatchShrink * old_area;
    is_undecided_ = is_undecided_ || (is_bad && !is_empty && !goes_on);
    is_active_ = is_active_ && (!is_bad || goes_on);
    for (int c = 0; c < 2; ++c) {
      box_[c].replace(goes_on, smaller[c]);
      at_[c] = select(goes_on, box_[c].middle(), at_[c]);
    }
  }
  TESSERA_INLINE PatchSide<T> narrowed(int c, T next, T away) const {
    return {max(next - away, box_[c].low), min(next + away, box_[c].high)};
  }

  TESSERA_INLINE void move(const typename Ray::Step& step) {
    const Mask moves = is_active_ && is_proved_;
    const T next[2] = {at_[0] + step.dx, at_[1] + step.dy};
    const T s = max(abs(step.dx) / box_[0].half, abs(step.dy) / box_[1].half);
    const T rest = left_ * s * s;  // in the norm
    const Mask is_last = moves && s <= 0x1p-8 && rest * box_[0].half <= kPatchStep &&
                         rest * box_[1].half <= kPatchStep;
    const Mask is_out = moves && !is_last &&
                        (abs(next[0]) - near_ * box_[0].half > 1 + tolerance_[0] ||
                         abs(next[1]) - near_ * box_[1].half > 1 + tolerance_[1]);
    t_ = select(is_last, step.t, t_);
    for (int c = 0; c < 2; ++c)
      at_[c] = select(is_last, next[c], select(moves, box_[c].clamped(next[c]), at_[c]));
    is_done_ = is_done_ || is_last;
    is_active_ = is_active_ && !is_last && !is_out;
  }

  const Ray& ray_;
  PatchSide<T> box_[2];
  T at_[2];
  Mask is_active_, is_proved_, is_undecided_, is_done_;
  T left_{}, near_{}, growth_{}, t_{}, tolerance_[2] = {};
};

// Requires: sub-patches with frames; local: their local_points().
template <class T, bool kRational, int kM, int kN, class N, class Points>
TESSERA_INLINE PatchDecision<T> decided_of(const PartNumbers<N>& part, Points local, int degree_u,
                                           int degree_v, const T (&origin)[3],
                                           const T (&direction)[3]) {
  const RayInFrame<T, N> ray(part, origin, direction);
  PatchDecider<T, N> decider(ray);
  for (int step = 0; step < kPatchStepsMax && !is_none<T>(decider.is_active()); ++step) {
    const T u = part.middle_u + part.half_u * decider.at(0);
    const T v = part.middle_v + part.half_v * decider.at(1);
    const PatchJet<T> jet = evaluated<T, kRational, kM, kN>(local, degree_u, degree_v, u, v);
    decider.take(ray.step(jet), step < kPatchNarrowingsMax);
  }
  return decider.answer(part);
}

// One sub-patch for all lanes. extent: of the patch.
template <class T, bool kRational, int kM, int kN>
TESSERA_INLINE PatchDecision<T> decided(const SubPatch& part, const PatchPoint* local, int degree_u,
                                        int degree_v, double extent, const T (&origin)[3],
                                        const T (&direction)[3]) {
  return decided_of<T, kRational, kM, kN>(numbers_of(part, extent), local, degree_u, degree_v,
                                          origin, direction);
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
