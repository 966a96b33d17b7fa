// SPDX-License-Identifier: Apache-2.0
// Control points of a patch in the frame of a sub-patch, for the rays of a packet: as
// local_points() has them, and where the patch is polynomial and bicubic by the same operations, a
// point per lane.
//
// Threads. Plain values.
#include "slave/core/primitive/patch/patch_layout.h"

#if defined(TESSERA_CORE_POINTS_IN_FRAME_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_POINTS_IN_FRAME_INL_H_
#undef TESSERA_CORE_POINTS_IN_FRAME_INL_H_
#else
#define TESSERA_CORE_POINTS_IN_FRAME_INL_H_
#endif

#include "slave/core/primitive/patch/patch_decision-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// kM, kN: the degrees where they are known when this is compiled, else 0.
template <bool kRational, int kM, int kN>
class PointsInFrame {
 public:
  HWY_INLINE PointsInFrame(const SubPatch& part, const Patch& patch) {
    local_points(part, patch, points_);
  }
  // What net_sums() takes.
  HWY_INLINE const PatchPoint* points() const { return points_; }

 private:
  PatchPoint points_[kM != 0 ? (kM + 1) * (kN + 1) : kPatchPointsMax];
};

struct CubicRows {
  const double (*x)[16];  // [axis]
};
template <class T>
HWY_INLINE T component_of(CubicRows points, int number, int a) {
  return set<T>(points.x[a][number]);
}

template <>
class PointsInFrame<false, 3, 3> {
 public:
  HWY_INLINE PointsInFrame(const SubPatch& part, const Patch& patch) {
    constexpr size_t kStep = kLaneCount < 16 ? kLaneCount : 16;
    alignas(64) float number[3][16];
    for (size_t at = 0; at < 16; at += kStep) {
      Floats p[3] = {};
      hn::LoadInterleaved3(TagOf<Floats>(), patch.numbers + 3 * at, p[0], p[1], p[2]);
      for (int a = 0; a < 3; ++a) store(p[a], number[a] + at);
    }
    for (size_t at = 0; at < 16; at += kLanesOf<Doubles>) {
      Doubles d[3] = {};
      for (int a = 0; a < 3; ++a)
        d[a] = in_double(number[a] + at) - static_cast<double>(part.centre[a]);
      for (int r = 0; r < 3; ++r)
        store(static_cast<double>(part.frame[r][0]) * d[0] +
                  static_cast<double>(part.frame[r][1]) * d[1] +
                  static_cast<double>(part.frame[r][2]) * d[2],
              x_[r] + at);
    }
  }
  HWY_INLINE CubicRows points() const { return {x_}; }

 private:
  alignas(64) double x_[3][16];
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
