// SPDX-License-Identifier: Apache-2.0
// Boxes of which it is proved that each has one root at most (quick_cubics-inl.h), a register of
// them ended in double. What counts is the float32 that the complete solver's t becomes: a box
// stays open where it is not certain which that is, or whether it is before t_min.
//
// As in patch_decision-inl.h a ray sees F(x, y) = (S_a - o_a - p (S_n - o_n), S_b - o_b - q (S_n -
// o_n)) in the frame of its sub-patch, and t = (S_n - o_n) / d_n. B_k bounds |F_xx| + 2 |F_xy| +
// |F_yy|, from the sub-patch's own `second`; Y is the inverse of F' at the last point z, m the size
// of Newton's step from there, e what roundings may add to it (below).
//
// The root. Y F' changes by |Y| B over a unit. Where |Y| B (m + e) <= 1/4, there is a root within
// 1.2 (m + e) of z, and no other that near (L. Kantorovich, "Functional analysis and applied
// mathematics", Uspekhi Mat. Nauk 3, 1948). F is off by B (m + e)^2 there from its linear part, so
// the root is within |Y| B (m + e)^2 + e of Newton's next point. It has to be within the box, since
// another one might be there otherwise, and in the square by 2^-10, where neighbours and the
// solver's tolerance at borders have no say.
//
// t. The complete solver's t is that of a tangent plane, too, at the point from which its last step
// leads next to the root. That step is at most 2^-20 of the side of its box, which lies in the
// first one; `half` below is half of the side of that. So either t is off by what is left of second
// order, B ((m + e)^2 + half^2 2^-38) in F_k and in S_n, carried on by Y and the slopes of S_n.
//
// Roundings are those of patch_decision-inl.h: F and S_n are off by at most the norms of the
// frame's rows times 2^-46 R, here and in the complete solver. Four times that stands for both.
//
// Threads. One call of a solver owns one.
#include "slave/core/primitive/patch/cubic_solver_layout.h"

#if defined(TESSERA_CORE_QUICK_ROOTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_QUICK_ROOTS_INL_H_
#undef TESSERA_CORE_QUICK_ROOTS_INL_H_
#else
#define TESSERA_CORE_QUICK_ROOTS_INL_H_
#endif

#include "slave/core/primitive/patch/cubic_lane_net-inl.h"
#include "slave/core/primitive/patch/lane_rows-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

// A register of questions about polynomial bicubic sub-patches, in the frames of these.
class QuickRays {
  using V = Doubles;

 public:
  static constexpr int kWidth = static_cast<int>(kLanesOf<V>);

  // F_1, F_2 and S_n - o_n, with their derivatives by x and y.
  struct Jet {
    V at[3], dx[3], dy[3];
  };

  // Puts question number[lane] into each lane.
  HWY_INLINE QuickRays(const PatchQuestion* questions, const int (&number)[kWidth]);

  HWY_INLINE Jet jet(V x, V y) const;
  // A place of the patch's square in that of the sub-patch.
  HWY_INLINE V place(int axis, V x) const { return (x - middle_[axis]) * scale_[axis]; }

  V inverse{};  // 1 / d_n
  V half{};     // of the side of the complete solver's first box
  V t_min{};
  V t_max{};       // where any hit will do, else -infinity
  V bend[3] = {};  // B_1, B_2 and that of S_n
  V off[3] = {};   // by roundings

 private:
  // 2^-(level + 1), without a division.
  static HWY_INLINE double half_of(int level) {
    return __builtin_bit_cast(double, static_cast<uint64_t>(1022 - level) << 52);
  }

  V half_[2] = {}, middle_[2] = {};  // of the sub-patch in the patch's square
  V scale_[2] = {};                  // 1 / half_
  alignas(64) double point_[48][kWidth];
};

QuickRays::QuickRays(const PatchQuestion* questions, const int (&number)[kWidth]) {
  const float* part[kWidth];
  const float* points[kWidth];
  const float* ray[kWidth];
  alignas(64) double halves[2][kWidth], middles[2][kWidth], extents[kWidth], ends[kWidth];
  for (int lane = 0; lane < kWidth; ++lane) {
    const PatchQuestion& q = questions[number[lane]];
    static_assert(offsetof(SubPatch, second) == 15 * sizeof(float));
    part[lane] = reinterpret_cast<const float*>(q.part);
    points[lane] = q.patch->numbers;
    ray[lane] = q.origin;
    halves[0][lane] = half_of(q.part->level_u);
    halves[1][lane] = half_of(q.part->level_v);
    middles[0][lane] = (2 * q.part->column + 1) * halves[0][lane];
    middles[1][lane] = (2 * q.part->row + 1) * halves[1][lane];
    extents[lane] = q.patch->extent;
    ends[lane] = static_cast<double>(q.is_any ? q.t_range[1] : -__builtin_inff());
  }
  for (int a = 0; a < 2; ++a) {
    half_[a] = load<V>(halves[a]);
    middle_[a] = load<V>(middles[a]);
    scale_[a] = 1 / half_[a];
  }
  V p[24] = {}, r[8] = {};
  each_row<24>(part, [&](int k, V x) HWY_ATTR { p[k] = x; });
  each_row<8>(ray, [&](int k, V x) HWY_ATTR { r[k] = x; });
  t_min = r[6];
  t_max = load<V>(ends);
  V from[3] = {}, o[3] = {}, d[3] = {}, norm[3] = {}, far = set<V>(0);
  for (int k = 0; k < 3; ++k) {
    from[k] = r[k] - p[9 + k];
    far = max(far, abs(from[k]));
  }
  for (int a = 0; a < 3; ++a) {
    const V* const row = p + 3 * a;
    o[a] = mul_add(row[2], from[2], mul_add(row[1], from[1], row[0] * from[0]));
    d[a] = mul_add(row[2], r[5], mul_add(row[1], r[4], row[0] * r[3]));
    norm[a] = abs(row[0]) + abs(row[1]) + abs(row[2]);
  }
  inverse = 1 / d[2];
  const V noise = (far + 2 * load<V>(extents)) * 0x1p-44;
  const auto second = [&](int k) HWY_ATTR { return p[15 + k] + 2 * p[18 + k] + p[21 + k]; };
  V row[3][3] = {}, shift[3] = {};
  bend[2] = second(2);
  off[2] = norm[2] * noise;
  half = set<V>(0);
  for (int a = 0; a < 2; ++a) {
    const V slope = d[a] * inverse, size = abs(slope);
    for (int k = 0; k < 3; ++k) row[a][k] = neg_mul_add(slope, p[6 + k], p[3 * a + k]);
    shift[a] = neg_mul_add(slope, o[2], o[a]);
    bend[a] = mul_add(size, bend[2], second(a));
    off[a] = mul_add(size, norm[2], norm[a]) * noise;
    half = max(half, mul_add(size, p[14], p[12 + a]) + 8 * off[a]);
  }
  half = min(half, set<V>(1 + 0x1p-18));
  for (int k = 0; k < 3; ++k) row[2][k] = p[6 + k];
  shift[2] = o[2];
  V x[3] = {};
  each_row<48>(points, [&](int number_of, V coordinate) HWY_ATTR {
    const int a = number_of % 3;
    x[a] = coordinate - p[9 + a];
    if (a < 2) return;
    for (int c = 0; c < 3; ++c)
      store(mul_add(row[c][2], x[2], mul_add(row[c][1], x[1], mul_sub(row[c][0], x[0], shift[c]))),
            point_[number_of - 2 + c]);
  });
}

QuickRays::Jet QuickRays::jet(V x, V y) const {
  V weight[2][4] = {}, slope[2][4] = {};
  const V at[2] = {x, y};
  for (int a = 0; a < 2; ++a)
    cubic_weights(mul_add(half_[a], at[a], middle_[a]), half_[a], weight[a], slope[a]);
  const auto sum = [](const V(&w)[4], const V(&of)[4]) HWY_ATTR {
    return mul_add(w[3], of[3], mul_add(w[2], of[2], mul_add(w[1], of[1], w[0] * of[0])));
  };
  Jet jet = {};
  for (int c = 0; c < 3; ++c) {
    V value[4] = {}, across[4] = {};
    for (int i = 0; i < 4; ++i) {
      V q[4] = {};
      for (int j = 0; j < 4; ++j) q[j] = load<V>(point_[3 * (4 * i + j) + c]);
      value[i] = sum(weight[1], q);
      across[i] = sum(slope[1], q);
    }
    jet.at[c] = sum(weight[0], value);
    jet.dx[c] = sum(slope[0], value);
    jet.dy[c] = sum(weight[0], across);
  }
  return jet;
}

class QuickRoots {
  using V = Doubles;
  using M = MaskOf<V>;
  using F = FloatOf<V>;

 public:
  static constexpr int kWidth = QuickRays::kWidth;

  // Puts the boxes of these lanes; `number` is of their questions, `guess` where Newton's iteration
  // begins, all in the squares of patches. is_single: it is proved that they have one root at most;
  // others are of use where any hit will do. Requires: fewer than kWidth wait.
  HWY_INLINE void put(MaskOf<Floats> lanes, Floats number, const Floats (&low)[2],
                      const Floats (&high)[2], const Floats (&guess)[2], bool is_single) {
    static_assert(kRoom >= kWidth - 1 + static_cast<int>(kLaneCount) + kWidth);
    store_packed(number, lanes, number_ + count_);
    store_packed(set<Floats>(is_single), lanes, single_ + count_);
    for (int a = 0; a < 2; ++a) {
      store_packed(low[a], lanes, low_[a] + count_);
      store_packed(high[a], lanes, high_[a] + count_);
      store_packed(guess[a], lanes, guess_[a] + count_);
    }
    count_ += static_cast<int>(count_of<Floats>(lanes));
  }
  HWY_INLINE bool is_empty() const { return count_ == 0; }
  HWY_INLINE bool is_enough() const { return count_ >= kWidth; }

  // Ends the first boxes, a register of them. Returns: bits of the questions that stay open.
  // Requires: there are some.
  HWY_NOINLINE uint64_t settle(const PatchQuestion* questions, QuickAnswer* to);

 private:
  static constexpr int kRoom = 2 * kWidth + 2 * static_cast<int>(kLaneCount);
  static constexpr int kStepsMax = 6;
  static constexpr double kNear = 0x1p-11;  // the step before the last one
  static constexpr double kLast = 0x1p-16;  // of the last one
  static constexpr double kInner = 1 - 0x1p-10;
  static constexpr double kPlacesOff = 0x1p-36;  // of limits in the square of a sub-patch

  struct Step {
    V by[2], unit;
    HWY_INLINE V size() const { return max(abs(by[0]), abs(by[1])); }
  };
  static HWY_INLINE Step step_of(const QuickRays::Jet& jet) {
    const V unit = 1 / (jet.dx[0] * jet.dy[1] - jet.dy[0] * jet.dx[1]);
    return {{(jet.dy[0] * jet.at[1] - jet.dy[1] * jet.at[0]) * unit,
             (jet.dx[1] * jet.at[0] - jet.dx[0] * jet.at[1]) * unit},
            unit};
  }
  HWY_INLINE void forget(int count);

  int count_ = 0;
  alignas(64) float number_[kRoom], single_[kRoom], low_[2][kRoom], high_[2][kRoom],
      guess_[2][kRoom];
};

uint64_t QuickRoots::settle(const PatchQuestion* questions, QuickAnswer* to) {
  const int some = min_of(count_, kWidth);
  const uint32_t there = (1u << some) - 1;
  int number[kWidth];
  for (int lane = 0; lane < kWidth; ++lane)
    number[lane] = static_cast<int>(number_[lane < some ? lane : 0]);
  const QuickRays rays(questions, number);
  const M lanes = first_lanes<V>(static_cast<size_t>(some));
  V low[2] = {}, high[2] = {}, at[2] = {};
  for (int a = 0; a < 2; ++a) {
    low[a] = rays.place(a, zero_unless(lanes, in_double(low_[a])));
    high[a] = rays.place(a, zero_unless(lanes, in_double(high_[a])));
    at[a] = rays.place(a, zero_unless(lanes, in_double(guess_[a])));
  }
  for (int k = 0; k < kStepsMax; ++k) {
    const Step step = step_of(rays.jet(at[0], at[1]));
    for (int a = 0; a < 2; ++a) at[a] = min(max(at[a] + step.by[a], low[a]), high[a]);
    if (is_none<V>(lanes && step.size() > set<V>(kNear))) break;
  }
  const QuickRays::Jet jet = rays.jet(at[0], at[1]);
  const Step last = step_of(jet);
  // |Y| times something of F.
  const auto moves = [&](const V(&f)[3], int a) HWY_ATTR {
    const V(&other)[3] = a == 0 ? jet.dy : jet.dx;
    return mul_add(abs(other[1]), f[0], abs(other[0]) * f[1]) * abs(last.unit);
  };
  const V e = max(moves(rays.off, 0), moves(rays.off, 1)), m = last.size() + e;
  M is_root = lanes && m <= set<V>(kLast) &&
              max(moves(rays.bend, 0), moves(rays.bend, 1)) * m <= set<V>(0.25);
  const V left = mul_add(m, m, 0x1p-38 * (rays.half * rays.half));
  V rest[3] = {};
  for (int c = 0; c < 3; ++c) rest[c] = mul_add(left, rays.bend[c], rays.off[c]);
  const V away[2] = {moves(rest, 0), moves(rest, 1)};
  M is_only = in_double(single_) > set<V>(0);
  for (int a = 0; a < 2; ++a) {
    const V next = at[a] + last.by[a], room = away[a] + kPlacesOff;
    is_root = is_root && abs(next) + away[a] <= set<V>(kInner);
    is_only = is_only && next - room >= low[a] && next + room <= high[a];
  }
  const V t = mul_add(jet.dy[2], last.by[1], mul_add(jet.dx[2], last.by[0], jet.at[2]));
  const V off = mul_add(abs(jet.dy[2]), away[1], mul_add(abs(jet.dx[2]), away[0], rest[2]));
  const V off_t = off * abs(rays.inverse), middle = t * rays.inverse;
  const F least = convert<F>(middle - off_t), most = convert<F>(middle + off_t);
  // A root out of the range is a miss, wherever it is. That there is another root as well is of no
  // interest where any will do.
  const M is_behind = is_root && middle - off_t > rays.t_min;
  const uint32_t any = bits_of<V>(rays.t_max > set<V>(-__builtin_inf()));
  const uint32_t exact = bits_of<V>(is_behind && is_only) & bits_of<F>(least == most) & ~any;
  const uint32_t hit = exact | bits_of<V>(is_behind && convert<V>(most) <= rays.t_max);
  const uint32_t before = bits_of<V>(is_root && is_only && middle + off_t < rays.t_min);
  const uint32_t beyond = bits_of<V>(is_behind && is_only && convert<V>(least) > rays.t_max) & any;
  const uint32_t known = hit | before | beyond;
  alignas(64) float found[kWidth];
  store(least, found);
  for (uint32_t hits = hit; hits != 0; hits &= hits - 1) {
    const int lane = __builtin_ctz(hits);
    QuickAnswer& best = to[number[lane]];
    if (best.is_hit && !(found[lane] < best.t)) continue;
    best.is_hit = true;
    best.t = found[lane];
  }
  uint64_t open = 0;
  for (uint32_t left_open = there & ~known; left_open != 0; left_open &= left_open - 1)
    open |= uint64_t{1} << number[__builtin_ctz(left_open)];
  forget(some);
  return open;
}

void QuickRoots::forget(int count) {
  count_ -= count;
  const auto move = [&](float* row) HWY_ATTR {
    for (int first = 0; first < count_; first += kWidth)
      store_unaligned(load_unaligned<F>(row + first + count), row + first);
  };
  move(number_);
  move(single_);
  for (int a = 0; a < 2; ++a) {
    move(low_[a]);
    move(high_[a]);
    move(guess_[a]);
  }
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
