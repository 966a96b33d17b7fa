// SPDX-License-Identifier: Apache-2.0
// Boxes that a filter in float32 (quick_cubics-inl.h, which derives what roundings add) has yet to
// look at, of many questions: in one row, a lane for each.
//
// Threads. One owner.
#include <stddef.h>

#include "slave/core/primitive/patch/cubic_solver_layout.h"

#if defined(TESSERA_CORE_QUICK_BOXES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_QUICK_BOXES_INL_H_
#undef TESSERA_CORE_QUICK_BOXES_INL_H_
#else
#define TESSERA_CORE_QUICK_BOXES_INL_H_
#endif

#include "slave/core/primitive/patch/cubic_net-inl.h"
#include "slave/core/primitive/patch/lane_rows-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

// Rays as they see the frames of their sub-patches: F_a = row_a (S - C) - at_a.
// p: frame, centre, reach; r: origin, direction.
struct QuickSight {
  Floats slope[2], at[2];
  Floats norm[2];  // |f_a| + |slope| |f_n|
  Floats off[2];   // of `at`, by roundings in double

  HWY_INLINE QuickSight(const Floats (&p)[16], const Floats (&r)[8]);
};

// A register of boxes.
struct QuickBox {
  Floats net[2][16];         // coefficients of F, number 4 i + j of B_i(x) B_j(y)
  Floats from[2], until[2];  // in the square of the patch
  Floats low[2], high[2];    // about the same in the square of the sub-patch
  Floats noise[2];           // what coefficients may be off by
  Floats number;             // of the question
  Floats age;
};

class QuickBoxes {
  using V = Floats;
  using M = MaskOf<V>;

 public:
  static constexpr int kWidth = static_cast<int>(kLaneCount);

  HWY_INLINE int count() const { return end_ - first_; }
  HWY_INLINE bool is_empty() const { return first_ == end_; }
  // Whether a register of boxes, and the other halves of all, find a place.
  HWY_INLINE bool has_room() {
    if (end_ + 2 * kWidth > kMost && first_ >= 2 * kWidth) move_down();
    return end_ + 2 * kWidth <= kMost;
  }

  // The first boxes of questions number first to first + count - 1.
  // Requires: count from 1 to kWidth; fewer than kWidth boxes.
  HWY_INLINE void put_first(const PatchQuestion* questions, int first, int count);

  // Takes the next boxes out, with their nets. Returns: lanes that have one.
  HWY_INLINE M take(QuickBox& box);

  // Puts the boxes of these lanes back, those of `halves` in two, along x where `by_x`.
  // Requires: has_room().
  HWY_INLINE void put(const QuickBox& box, M lanes, M halves, M by_x);

 private:
  static constexpr int kMost = 64 + 4 * kWidth;
  enum Row {
    kFrom = 0,
    kUntil = 2,
    kLow = 4,
    kHigh = 6,
    kNoise = 8,
    kNumber = 10,
    kAge = 11,
    kRows = 12
  };

  // Puts some lanes side by side.
  class Packing {
   public:
    HWY_INLINE explicit Packing(M lanes)
        : from_(hn::IndicesFromVec(
              TagOf<V>(), hn::Compress(counting_from<IntOf<V> >(0), mask_as<IntOf<V> >(lanes)))) {}
    HWY_INLINE V operator()(V x) const { return hn::TableLookupLanes(x, from_); }

   private:
    decltype(hn::IndicesFromVec(TagOf<V>(), IntOf<V>())) from_;
  };
  // Shape: questions, to [count]. Returns: the largest coordinates of control points from centres.
  static HWY_INLINE V put_nets(const PatchQuestion* questions, int count, const QuickSight& sight,
                               float (*to)[2][16]);
  HWY_INLINE void append(const QuickBox& box, M lanes);
  HWY_NOINLINE void move_down();
  template <int kStep>
  static HWY_INLINE void cut_four(const V (&old)[4], const CubicCut<V>& cut, V* to);

  int first_ = 0, end_ = 0;
  alignas(64) float row_[kRows][kMost + kWidth];
  alignas(64) float net_[kQuickMost][2][16];  // of questions, over their patches
};

QuickSight::QuickSight(const Floats (&p)[16], const Floats (&r)[8]) {
  using V = Floats;
  Doubles slopes[2][2] = {}, places[2][2] = {};  // [axis][half of the register]
  for (int h = 0; h < 2; ++h) {
    const auto wide = [&](V x) HWY_ATTR {
      const hn::Half<TagOf<V> > half;
      return convert<Doubles>(h == 0 ? hn::LowerHalf(half, x) : hn::UpperHalf(half, x));
    };
    Doubles from[3] = {}, direction[3] = {}, o[3] = {}, d[3] = {};
    for (int k = 0; k < 3; ++k) {
      from[k] = wide(r[k]) - wide(p[9 + k]);
      direction[k] = wide(r[3 + k]);
    }
    for (int a = 0; a < 3; ++a) {
      const Doubles x = wide(p[3 * a]), y = wide(p[3 * a + 1]), z = wide(p[3 * a + 2]);
      o[a] = mul_add(z, from[2], mul_add(y, from[1], x * from[0]));
      d[a] = mul_add(z, direction[2], mul_add(y, direction[1], x * direction[0]));
    }
    const Doubles inverse = 1 / d[2];
    for (int a = 0; a < 2; ++a) {
      slopes[a][h] = d[a] * inverse;
      places[a][h] = neg_mul_add(o[2], slopes[a][h], o[a]);
    }
  }
  V far = set<V>(0);
  for (int k = 0; k < 3; ++k) far = max(far, abs(r[k] - p[9 + k]));
  for (int a = 0; a < 2; ++a) {
    const auto narrow = [](const Doubles(&x)[2]) HWY_ATTR {
      using F = FloatOf<Doubles>;
      return hn::Combine(TagOf<V>(), convert<F>(x[1]), convert<F>(x[0]));
    };
    slope[a] = narrow(slopes[a]);
    at[a] = narrow(places[a]);
    V sizes[2] = {set<V>(0), set<V>(0)};
    for (int k = 0; k < 3; ++k) {
      sizes[0] = sizes[0] + abs(p[3 * a + k]);
      sizes[1] = sizes[1] + abs(p[6 + k]);
    }
    norm[a] = mul_add(abs(slope[a]), sizes[1], sizes[0]);
    off[a] = 0x1p-45f * (norm[a] * far);
  }
}

void QuickBoxes::put_first(const PatchQuestion* questions, int first, int count) {
  using I = IntOf<V>;
  const float* part[kWidth];
  const float* ray[kWidth];
  alignas(64) int32_t levels[2][kWidth], cells[2][kWidth];
  for (int lane = 0; lane < kWidth; ++lane) {
    const PatchQuestion& q = questions[first + min_of(lane, count - 1)];
    static_assert(offsetof(PatchQuestion, direction) - offsetof(PatchQuestion, origin) == 12);
    part[lane] = reinterpret_cast<const float*>(q.part);
    ray[lane] = q.origin;
    levels[0][lane] = q.part->level_u;
    levels[1][lane] = q.part->level_v;
    cells[0][lane] = q.part->column;
    cells[1][lane] = q.part->row;
  }
  V p[16] = {}, r[8] = {};  // frame, centre, reach; origin, direction, t_range
  each_float_row<16>(part, [&](int k, V x) HWY_ATTR { p[k] = x; });
  each_float_row<8>(ray, [&](int k, V x) HWY_ATTR { r[k] = x; });
  const QuickSight sight(p, r);
  QuickBox box;
  const V far = put_nets(questions + first, count, sight, net_ + first);
  M is_there = first_lanes<V>(static_cast<size_t>(count));
  for (int a = 0; a < 2; ++a) {
    const V size = mul_add(sight.norm[a], far, abs(sight.at[a]));
    box.noise[a] = mul_add(set<V>(48 * kRoundoff), size, sight.off[a]);
    const V half = hn::BitCast(TagOf<V>(), hn::ShiftLeft<23>(set<I>(126) - load<I>(levels[a])));
    const V middle = convert<V>(hn::ShiftLeft<1>(load<I>(cells[a])) + set<I>(1)) * half;
    const V off = 0x1p-20f + 0x1p-23f / half, most = off + (1 + 0x1p-12f);
    const V reach =
        mul_add(abs(sight.slope[a]), p[14], p[12 + a]) * (1 + 0x1p-20f) + box.noise[a] + off;
    box.low[a] = max(sight.at[a] - reach, -most);
    box.high[a] = min(sight.at[a] + reach, most);
    is_there = is_there && !(box.low[a] > box.high[a]);
    box.from[a] = mul_add(half, box.low[a], middle);
    box.until[a] = mul_add(half, box.high[a], middle);
  }
  box.number = counting_from<V>(static_cast<float>(first));
  box.age = set<V>(0);
  if (end_ + kWidth > kMost) move_down();
  append(box, is_there);
}

QuickBoxes::V QuickBoxes::put_nets(const PatchQuestion* questions, int count,
                                   const QuickSight& sight, float (*to)[2][16]) {
  constexpr int kStep = kWidth < 16 ? kWidth : 16;
  alignas(64) float slope[2][kWidth], at[2][kWidth], far[kWidth] = {};
  for (int a = 0; a < 2; ++a) {
    store(sight.slope[a], slope[a]);
    store(sight.at[a], at[a]);
  }
  const SubPatch* part = nullptr;  // that of `local`: questions of a packet share parts
  V local[3][16 / kStep] = {}, farthest = {};
  float far_of_part = 0;
  for (int k = 0; k < count; ++k) {
    if (questions[k].part != part) {
      part = questions[k].part;
      farthest = set<V>(0);
      for (int n = 0; n < 16 / kStep; ++n) {
        V x[3] = {};
        hn::LoadInterleaved3(TagOf<V>(), questions[k].patch->numbers + 3 * kStep * n, x[0], x[1],
                             x[2]);
        for (int a = 0; a < 3; ++a) {
          x[a] = x[a] - part->centre[a];
          farthest = max(farthest, abs(x[a]));
        }
        for (int a = 0; a < 3; ++a)
          local[a][n] = mul_add(x[2], set<V>(part->frame[a][2]),
                                mul_add(x[1], set<V>(part->frame[a][1]), x[0] * part->frame[a][0]));
      }
      far_of_part = greatest_lane(farthest);
    }
    far[k] = far_of_part;
    for (int a = 0; a < 2; ++a) {
      const V by = set<V>(slope[a][k]), place = set<V>(at[a][k]);
      for (int n = 0; n < 16 / kStep; ++n)
        store(neg_mul_add(by, local[2][n], local[a][n]) - place, to[k][a] + kStep * n);
    }
  }
  return load<V>(far);
}

QuickBoxes::M QuickBoxes::take(QuickBox& box) {
  const int some = min_of(count(), kWidth);
  const auto next = [&](int row) HWY_ATTR { return load_unaligned<V>(row_[row] + first_); };
  box.number = next(kNumber);
  const float* net[kWidth];
  for (int lane = 0; lane < kWidth; ++lane)
    net[lane] = net_[static_cast<int>(row_[kNumber][first_ + min_of(lane, some - 1)])][0];
  for (int a = 0; a < 2; ++a) {
    box.from[a] = next(kFrom + a);
    box.until[a] = next(kUntil + a);
    box.low[a] = next(kLow + a);
    box.high[a] = next(kHigh + a);
    box.noise[a] = next(kNoise + a);
  }
  const CubicCut<V> by_x(box.from[0], box.until[0]), by_y(box.from[1], box.until[1]);
  V row[4] = {};
  each_float_row<32>(net, [&](int n, V x) HWY_ATTR {
    row[n % 4] = x;
    if (n % 4 == 3) cut_four<1>(row, by_y, box.net[n / 16] + n % 16 - 3);
  });
  for (V(&of)[16] : box.net)
    for (int j = 0; j < 4; ++j) {
      const V old[4] = {of[j], of[4 + j], of[8 + j], of[12 + j]};
      cut_four<4>(old, by_x, of + j);
    }
  box.age = next(kAge);
  first_ += some;
  if (is_empty()) first_ = end_ = 0;
  return first_lanes<V>(static_cast<size_t>(some));
}

void QuickBoxes::put(const QuickBox& box, M lanes, M halves, M by_x) {
  const M by[2] = {halves && by_x, and_not(by_x, halves)};
  QuickBox half = box;
  V middle[2][2] = {};
  for (int a = 0; a < 2; ++a) {
    middle[a][0] = 0.5f * (box.from[a] + box.until[a]);
    middle[a][1] = 0.5f * (box.low[a] + box.high[a]);
    half.until[a] = select(by[a], middle[a][0], box.until[a]);
    half.high[a] = select(by[a], middle[a][1], box.high[a]);
  }
  append(half, lanes);
  if (is_none<V>(halves)) return;
  for (int a = 0; a < 2; ++a) {
    half.from[a] = select(by[a], middle[a][0], box.from[a]);
    half.low[a] = select(by[a], middle[a][1], box.low[a]);
    half.until[a] = box.until[a];
    half.high[a] = box.high[a];
  }
  append(half, halves);
}

void QuickBoxes::append(const QuickBox& box, M lanes) {
  const Packing packed(lanes);
  const auto put = [&](int row, V x) HWY_ATTR { store_unaligned(packed(x), row_[row] + end_); };
  for (int k = 0; k < 2; ++k) {
    put(kFrom + k, box.from[k]);
    put(kUntil + k, box.until[k]);
    put(kLow + k, box.low[k]);
    put(kHigh + k, box.high[k]);
    put(kNoise + k, box.noise[k]);
  }
  put(kNumber, box.number);
  put(kAge, box.age);
  end_ += static_cast<int>(count_of<V>(lanes));
}

void QuickBoxes::move_down() {
  for (auto& row : row_)
    for (int from = first_; from < end_; from += kWidth)
      store_unaligned(load_unaligned<V>(row + from), row + (from - first_));
  end_ -= first_;
  first_ = 0;
}

template <int kStep>
void QuickBoxes::cut_four(const V (&old)[4], const CubicCut<V>& cut, V* to) {
  for (int i = 0; i < 4; ++i) {
    const V(&w)[4] = cut.weight[i];
    to[kStep * i] =
        mul_add(w[3], old[3], mul_add(w[2], old[2], mul_add(w[1], old[1], w[0] * old[0])));
  }
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
