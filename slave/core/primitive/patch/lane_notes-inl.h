// SPDX-License-Identifier: Apache-2.0
// Rows of numbers that the lanes of a register put aside, each lane as many as it needs: a stack or
// a list for each.
//
// Threads. One owner.
#if defined(TESSERA_CORE_LANE_NOTES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_LANE_NOTES_INL_H_
#undef TESSERA_CORE_LANE_NOTES_INL_H_
#else
#define TESSERA_CORE_LANE_NOTES_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// kCount: the most that a lane has; kRows: the numbers of one.
template <int kCount, int kRows>
struct LaneNotes {
  static constexpr int kWidth = static_cast<int>(kLanesOf<Doubles>);

  int count[kWidth] = {};
  alignas(64) double rows[kCount][kRows][kWidth];

  // Calls what(number, same) for each count that some of the lanes have, and those lanes.
  template <class What>
  HWY_INLINE void by_count(uint32_t lanes, const What& what) const {
    while (lanes != 0) {
      const int number = count[__builtin_ctz(lanes)];
      uint32_t same = 0;
      for (uint32_t left = lanes; left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        if (count[lane] == number) same |= 1u << lane;
      }
      what(number, same);
      lanes &= ~same;
    }
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
