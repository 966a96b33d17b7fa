// SPDX-License-Identifier: Apache-2.0
// Numbers that each lane has in memory, one after the other, brought side by side: row k has number
// k of every lane. Where a register has eight doubles, eight numbers of eight lanes are loaded in
// eight loads and turned in registers; elsewhere lanes are few, and numbers are taken one by one.
//
// Threads. Pure functions.
#if defined(TESSERA_CORE_LANE_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_LANE_ROWS_INL_H_
#undef TESSERA_CORE_LANE_ROWS_INL_H_
#else
#define TESSERA_CORE_LANE_ROWS_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_AVX3
// Rows become columns.
HWY_INLINE void turn(Doubles (&x)[8]) {
  const TagOf<Doubles> d;
  Doubles half[2][4] = {};  // [numbers 0 to 3, 4 to 7]
  for (int i = 0; i < 4; ++i) {
    half[0][i] = hn::ConcatLowerLower(d, x[i + 4], x[i]);
    half[1][i] = hn::ConcatUpperUpper(d, x[i + 4], x[i]);
  }
  for (int h = 0; h < 2; ++h) {
    Doubles pair[2][2] = {};  // [numbers 0 and 1, 2 and 3][even lanes, odd lanes]
    for (int i = 0; i < 2; ++i) {
      const Doubles a = half[h][i], b = half[h][i + 2];
      pair[0][i] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(b), a);
      pair[1][i] = hn::OddEvenBlocks(b, hn::SwapAdjacentBlocks(a));
    }
    for (int p = 0; p < 2; ++p) {
      x[4 * h + 2 * p] = hn::InterleaveLower(d, pair[p][0], pair[p][1]);
      x[4 * h + 2 * p + 1] = hn::InterleaveUpper(d, pair[p][0], pair[p][1]);
    }
  }
}
#endif

// Calls take(k, row) for k from 0 to kCount - 1. Shape: from [lanes], each to kCount numbers.
template <int kCount, class Take>
HWY_INLINE void each_row(const float* const (&from)[kLanesOf<Doubles>], const Take& take) {
  static_assert(kCount % 8 == 0);
#if HWY_TARGET == HWY_AVX3
  for (int first = 0; first < kCount; first += 8) {
    Doubles x[8] = {};
    for (int lane = 0; lane < 8; ++lane)
      x[lane] = convert<Doubles>(load_unaligned<FloatOf<Doubles>>(from[lane] + first));
    turn(x);
    for (int k = 0; k < 8; ++k) take(first + k, x[k]);
  }
#else
  for (int k = 0; k < kCount; ++k) {
    alignas(64) double x[kLanesOf<Doubles>];
    for (size_t lane = 0; lane < kLanesOf<Doubles>; ++lane) {
      float number;
      __builtin_memcpy(&number, reinterpret_cast<const char*>(from[lane]) + 4 * k, sizeof number);
      x[lane] = static_cast<double>(number);
    }
    take(k, load<Doubles>(x));
  }
#endif
}

#if HWY_TARGET != HWY_SCALAR
// The same for registers of float, four numbers of each lane at once. Shape: from [kLaneCount].
template <int kCount, class Take>
HWY_INLINE void each_float_row(const float* const (&from)[kLaneCount], const Take& take) {
  static_assert(kCount % 4 == 0);
  const TagOf<Floats> d;
  for (int first = 0; first < kCount; first += 4) {
    // Block b of register r has numbers of lane 4 b + r.
    Floats x[4] = {};
    for (size_t r = 0; r < 4; ++r) {
      const auto block = [&](size_t b) HWY_ATTR {
        return load_unaligned<FloatsOf<4>>(from[4 * b + r] + first);
      };
#if HWY_TARGET == HWY_AVX3
      const TagOf<FloatsOf<8>> half;
      x[r] = hn::Combine(d, hn::Combine(half, block(3), block(2)),
                         hn::Combine(half, block(1), block(0)));
#elif HWY_TARGET == HWY_AVX2
      x[r] = hn::Combine(d, block(1), block(0));
#else
      x[r] = block(0);
#endif
    }
    const Floats even[2] = {hn::InterleaveLower(d, x[0], x[2]), hn::InterleaveUpper(d, x[0], x[2])};
    const Floats odd[2] = {hn::InterleaveLower(d, x[1], x[3]), hn::InterleaveUpper(d, x[1], x[3])};
    for (int k = 0; k < 2; ++k) {
      take(first + 2 * k, hn::InterleaveLower(d, even[k], odd[k]));
      take(first + 2 * k + 1, hn::InterleaveUpper(d, even[k], odd[k]));
    }
  }
}
#endif

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
