// SPDX-License-Identifier: Apache-2.0
// A register of questions for the complete solver: rays, sub-patches, and their control points as
// the rays' origins see them, one in each lane. Lanes do what CubicPoints does, operation by
// operation.
//
// Threads. One call of a solver owns one.
#include "slave/core/primitive/patch/cubic_solver_layout.h"

#if defined(TESSERA_CORE_CUBIC_LANE_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_CUBIC_LANE_POINTS_INL_H_
#undef TESSERA_CORE_CUBIC_LANE_POINTS_INL_H_
#else
#define TESSERA_CORE_CUBIC_LANE_POINTS_INL_H_
#endif

#include "slave/core/primitive/patch/cubic_lane_net-inl.h"
#include "slave/core/primitive/patch/cubic_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class CubicLanePoints {
  using V = Doubles;

 public:
  static constexpr int kWidth = static_cast<int>(kLanesOf<V>);

  struct Jet {
    LaneTriple point, du, dv;  // derivatives by x, y
  };

  // Puts question number[lane] into each lane of these bits; others keep what they have.
  // Requires: lanes that have nothing yet are among them.
  HWY_INLINE void load_all(const PatchQuestion* questions, const int* number, uint32_t lanes);

  HWY_INLINE V origin(int a) const { return load<V>(ray_[a]); }
  HWY_INLINE LaneTriple direction() const {
    return {load<V>(ray_[3]), load<V>(ray_[4]), load<V>(ray_[5])};
  }
  HWY_INLINE V t_min() const { return load<V>(ray_[6]); }
  HWY_INLINE V t_max() const { return load<V>(ray_[7]); }
  HWY_INLINE V frame(int r, int k) const { return load<V>(part_[3 * r + k]); }
  HWY_INLINE V centre(int k) const { return load<V>(part_[9 + k]); }
  HWY_INLINE V reach(int r) const { return load<V>(part_[12 + r]); }
  HWY_INLINE V extent() const { return load<V>(part_[15]); }
  HWY_INLINE V half(int a) const { return load<V>(part_[16 + a]); }
  HWY_INLINE V middle(int a) const { return load<V>(part_[18 + a]); }
  HWY_INLINE MaskOf<V> has_frame() const { return load<V>(part_[20]) != set<V>(0); }
  HWY_INLINE V far() const { return load<V>(far_); }
  HWY_INLINE V low_w() const { return load<V>(weight_[0]); }
  HWY_INLINE V high_w() const { return load<V>(weight_[1]); }

  // w x, w y and w z of point number 4 i + j, relative to the origin.
  HWY_INLINE LaneTriple point(int number) const {
    return {load<V>(point_[number][0]), load<V>(point_[number][1]), load<V>(point_[number][2])};
  }
  HWY_INLINE Jet jet_at(V x, V y) const {
    return is_any_rational_ ? jet<true>(x, y) : jet<false>(x, y);
  }

 private:
  HWY_INLINE void put_ray(int lane, const PatchQuestion& question);
  HWY_INLINE void put_part(uint32_t lanes, const PatchQuestion& question);
  HWY_INLINE void put_bicubic(uint32_t lanes, const Patch& patch);
  HWY_NOINLINE void put_other(int lane, const PatchQuestion& question);
  static HWY_INLINE bool is_bicubic(const Patch& patch) {
    return !patch.is_rational && patch.degree_u == 3 && patch.degree_v == 3;
  }
  template <bool kRational>
  HWY_INLINE Jet jet(V x, V y) const;

  static constexpr int kPartNumbers = 21;

  bool is_any_rational_ = false;
  alignas(64) double ray_[8][kWidth];  // origin, direction, least and greatest t
  alignas(64) double part_[kPartNumbers][kWidth];
  alignas(64) double point_[16][4][kWidth];
  alignas(64) double far_[kWidth], weight_[2][kWidth];  // the farthest coordinate, weights' range
  alignas(64) double rational_[kWidth];                 // 1 where it is
};

void CubicLanePoints::load_all(const PatchQuestion* questions, const int* number, uint32_t lanes) {
  for (uint32_t left = lanes; left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    put_ray(lane, questions[number[lane]]);
  }
  while (lanes != 0) {
    const PatchQuestion& first = questions[number[__builtin_ctz(lanes)]];
    uint32_t same = 0;
    for (uint32_t left = lanes; left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      if (questions[number[lane]].part == first.part) same |= 1u << lane;
    }
    lanes &= ~same;
    put_part(same, first);
    if (is_bicubic(*first.patch)) {
      put_bicubic(same, *first.patch);
    } else {
      for (; same != 0; same &= same - 1)
        put_other(__builtin_ctz(same), questions[number[__builtin_ctz(same)]]);
    }
  }
}

void CubicLanePoints::put_ray(int lane, const PatchQuestion& question) {
  for (int a = 0; a < 3; ++a) {
    ray_[a][lane] = static_cast<double>(question.origin[a]);
    ray_[3 + a][lane] = static_cast<double>(question.direction[a]);
  }
  for (int a = 0; a < 2; ++a) ray_[6 + a][lane] = static_cast<double>(question.t_range[a]);
}

void CubicLanePoints::put_part(uint32_t lanes, const PatchQuestion& question) {
  const MaskOf<V> where = mask_of<V>(lanes);
  const SubPatch& part = *question.part;
  const auto put = [&](int row, double x) HWY_ATTR { store_where(where, set<V>(x), part_[row]); };
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) put(3 * r + k, static_cast<double>(part.frame[r][k]));
    put(9 + r, static_cast<double>(part.centre[r]));
    put(12 + r, static_cast<double>(part.reach[r]));
  }
  put(15, question.patch->extent);
  const double half[2] = {1.0 / (2u << part.level_u), 1.0 / (2u << part.level_v)};
  put(16, half[0]);
  put(17, half[1]);
  put(18, (2 * part.column + 1) * half[0]);
  put(19, (2 * part.row + 1) * half[1]);
  put(20, part.has_frame ? 1 : 0);
}

void CubicLanePoints::put_bicubic(uint32_t lanes, const Patch& patch) {
  const MaskOf<V> where = mask_of<V>(lanes);
  const V from[3] = {origin(0), origin(1), origin(2)};
  V size = set<V>(0);
  for (int k = 0; k < 16; ++k)
    for (int a = 0; a < 3; ++a) {
      const V x = static_cast<double>(patch.numbers[3 * k + a]) - from[a];
      size = max(size, abs(x));
      store_where(where, x, point_[k][a]);
    }
  store_where(where, size, far_);
  for (auto& weight : weight_) store_where(where, set<V>(1), weight);
  store_where(where, set<V>(0), rational_);
}

void CubicLanePoints::put_other(int lane, const PatchQuestion& question) {
  CubicPoints points(*question.part);
  points.load(*question.patch, question.origin);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      double x[4];
      points.point[i][j].store(x);
      for (int a = 0; a < 4; ++a) point_[4 * i + j][a][lane] = x[a];
    }
  far_[lane] = points.far;
  weight_[0][lane] = points.low_w;
  weight_[1][lane] = points.high_w;
  rational_[lane] = points.is_rational ? 1 : 0;
  is_any_rational_ = is_any_rational_ || points.is_rational;
}

template <bool kRational>
CubicLanePoints::Jet CubicLanePoints::jet(V x, V y) const {
  V weight[2][4] = {}, slope[2][4] = {};
  cubic_weights(middle(0) + half(0) * x, half(0), weight[0], slope[0]);
  cubic_weights(middle(1) + half(1) * y, half(1), weight[1], slope[1]);
  constexpr int kComponents = kRational ? 4 : 3;
  V of[3][4] = {};
  for (int a = 0; a < kComponents; ++a) {
    for (int i = 0; i < 4; ++i) {
      V p[4] = {};
      for (int j = 0; j < 4; ++j) p[j] = load<V>(point_[4 * i + j][a]);
      const V value =
          (weight[1][0] * p[0] + weight[1][1] * p[1]) + (weight[1][2] * p[2] + weight[1][3] * p[3]);
      const V across =
          (slope[1][0] * p[0] + slope[1][1] * p[1]) + (slope[1][2] * p[2] + slope[1][3] * p[3]);
      of[0][a] = of[0][a] + weight[0][i] * value;
      of[1][a] = of[1][a] + slope[0][i] * value;
      of[2][a] = of[2][a] + weight[0][i] * across;
    }
  }
  if constexpr (!kRational) {
    return {{of[0][0], of[0][1], of[0][2]},
            {of[1][0], of[1][1], of[1][2]},
            {of[2][0], of[2][1], of[2][2]}};
  }
  // Polynomial ones among them have a weight of 1, which does not change.
  const auto is_rational = load<V>(rational_) != set<V>(0);
  const V inverse = select(is_rational, 1 / of[0][3], set<V>(1));
  const V s[3] = {of[0][0] * inverse, of[0][1] * inverse, of[0][2] * inverse};
  const auto derivative = [&](const V(&d)[4]) HWY_ATTR {
    const V change = zero_unless(is_rational, d[3]);
    return LaneTriple{(d[0] - s[0] * change) * inverse, (d[1] - s[1] * change) * inverse,
                      (d[2] - s[2] * change) * inverse};
  };
  return {{s[0], s[1], s[2]}, derivative(of[1]), derivative(of[2])};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
