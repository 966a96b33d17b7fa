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
  Floats row[2][3], norm[2];  // norm: |f_a| + |slope| |f_n|
  Floats off[2];              // of `at`, by roundings in double

  HWY_INLINE QuickSight(const Floats (&p)[16], const Floats (&r)[8]);
};

// A register of boxes. Nets are of what they were cut from: they are to be cut to [from, until].
struct QuickBox {
  Floats net[2][16];         // coefficients of F, number 4 i + j of B_i(x) B_j(y)
  Floats from[2], until[2];  // in [0, 1] of the nets' square
  Floats low[2], high[2];    // of the box, in the square of the sub-patch
  Floats noise[2];           // what coefficients may be off by, and what cutting them will add
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

  // Takes the next boxes out, cut to what is to be looked at. Returns: lanes that have one.
  HWY_INLINE M take(QuickBox& box);

  // Puts the boxes of these lanes back, those of `halves` in two, along x where `by_x`.
  // Requires: has_room().
  HWY_INLINE void put(const QuickBox& box, M lanes, M halves, M by_x);

 private:
  static constexpr int kMost = 64 + 4 * kWidth;
  enum Row {
    kNet = 0,
    kFrom = 32,
    kUntil = 34,
    kLow = 36,
    kHigh = 38,
    kNoise = 40,
    kNumber = 42,
    kAge = 43,
    kRows = 44
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
  HWY_INLINE void append(const QuickBox& box, M lanes);
  HWY_NOINLINE void move_down();
  template <int kAxis>
  static HWY_INLINE void cut(V (&net)[16], const CubicCut<V>& cut);

  int first_ = 0, end_ = 0;
  alignas(64) float row_[kRows][kMost + kWidth];
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
      row[a][k] = neg_mul_add(slope[a], p[6 + k], p[3 * a + k]);
      sizes[0] = sizes[0] + abs(p[3 * a + k]);
      sizes[1] = sizes[1] + abs(p[6 + k]);
    }
    norm[a] = mul_add(abs(slope[a]), sizes[1], sizes[0]);
    off[a] = 0x1p-45f * (norm[a] * far);
  }
}

void QuickBoxes::put_first(const PatchQuestion* questions, int first, int count) {
  const float* part[kWidth];
  const float* points[kWidth];
  const float* ray[kWidth];
  alignas(64) float middles[2][kWidth], halves[2][kWidth];
  for (int lane = 0; lane < kWidth; ++lane) {
    const PatchQuestion& q = questions[first + min_of(lane, count - 1)];
    static_assert(offsetof(PatchQuestion, direction) - offsetof(PatchQuestion, origin) == 12);
    part[lane] = reinterpret_cast<const float*>(q.part);
    points[lane] = q.patch->numbers;
    ray[lane] = q.origin;
    halves[0][lane] = 1 / static_cast<float>(2u << q.part->level_u);
    halves[1][lane] = 1 / static_cast<float>(2u << q.part->level_v);
    middles[0][lane] = static_cast<float>(2 * q.part->column + 1) * halves[0][lane];
    middles[1][lane] = static_cast<float>(2 * q.part->row + 1) * halves[1][lane];
  }
  V p[16] = {}, r[8] = {};  // frame, centre, reach; origin, direction, t_range
  each_float_row<16>(part, [&](int k, V x) HWY_ATTR { p[k] = x; });
  each_float_row<8>(ray, [&](int k, V x) HWY_ATTR { r[k] = x; });
  const QuickSight sight(p, r);
  QuickBox box;
  V x[3] = {}, far = set<V>(0);
  each_float_row<48>(points, [&](int number, V coordinate) HWY_ATTR {
    const int a = number % 3;
    x[a] = coordinate - p[9 + a];
    far = max(far, abs(x[a]));
    if (a < 2) return;
    for (int k = 0; k < 2; ++k)
      box.net[k][number / 3] =
          mul_add(sight.row[k][2], x[2],
                  mul_add(sight.row[k][1], x[1], mul_sub(sight.row[k][0], x[0], sight.at[k])));
  });
  M is_there = first_lanes<V>(static_cast<size_t>(count));
  for (int a = 0; a < 2; ++a) {
    const V size = mul_add(sight.norm[a], far, abs(sight.at[a]));
    box.noise[a] = mul_add(set<V>(48 * kRoundoff), size, sight.off[a]);
    const V half = load<V>(halves[a]), middle = load<V>(middles[a]);
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

QuickBoxes::M QuickBoxes::take(QuickBox& box) {
  const int some = min_of(count(), kWidth);
  const auto next = [&](int row) HWY_ATTR { return load_unaligned<V>(row_[row] + first_); };
  for (int k = 0; k < 2; ++k)
    for (int n = 0; n < 16; ++n) box.net[k][n] = next(kNet + 16 * k + n);
  for (int a = 0; a < 2; ++a) {
    const CubicCut<V> part(next(kFrom + a), next(kUntil + a));
    for (V(&net)[16] : box.net) a == 0 ? cut<0>(net, part) : cut<1>(net, part);
    box.low[a] = next(kLow + a);
    box.high[a] = next(kHigh + a);
    box.noise[a] = next(kNoise + a);
  }
  box.number = next(kNumber);
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
    for (int n = 0; n < 16; ++n) put(kNet + 16 * k + n, box.net[k][n]);
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

template <int kAxis>
void QuickBoxes::cut(V (&net)[16], const CubicCut<V>& cut) {
  constexpr int kStep = kAxis == 0 ? 4 : 1, kNext = kAxis == 0 ? 1 : 4;
  for (int j = 0; j < 4; ++j) {
    V* const x = net + kNext * j;
    const V old[4] = {x[0], x[kStep], x[2 * kStep], x[3 * kStep]};
    for (int i = 0; i < 4; ++i) {
      const V(&w)[4] = cut.weight[i];
      x[kStep * i] =
          mul_add(w[3], old[3], mul_add(w[2], old[2], mul_add(w[1], old[1], w[0] * old[0])));
    }
  }
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
