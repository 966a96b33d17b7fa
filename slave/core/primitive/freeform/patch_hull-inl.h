// SPDX-License-Identifier: Apache-2.0
// Which rays pass a whole patch by: the hull of its control points as each ray sees them, in
// float32, a ray per lane. It tells rays from large curved parts, around which the parallelepiped
// of patch_filter-inl.h leaves much room.
//
// Seen along the ray, in the frame (patch_decision-inl.h), control points are F = (x, y) with
//   x = (L_a - p L_n) - (o_a - p o_n),  L = frame (P - centre),
// and so y, and the ray is 0. A ray from which all control points lie to one side, by x, y, x + y
// or x - y, meets nothing of the patch.
//
// Room, with u, N_r, S, R of patch_filter-inl.h and E the farthest coordinate of a control point
// from the centre. The second bracket is off by 8 u (N_a + |p| N_n) (R + |t| S) there. L_r is off
// by 5 u N_r E (a difference, a product, two sums), p by 4 u (N_a + |p| N_n) S / |d_n| + 2 u |p|,
// which is multiplied with N_n E; two roundings follow. So the first is off by less than
// 8 u (N_a + |p| N_n) (1 + S N_n / |d_n|) E. Twice both is allowed. A hit may lie kSquareWiden of a
// half width beyond the patch, where the surface has left the hull by less than 2^-18 N_r E: 2^-17
// stands. The sums x + y and x - y have a rounding more, of numbers within the same bounds, and the
// room of both. Rays for which any of this is not a number stay.
//
// Threads. Pure functions.
#include "slave/core/primitive/patch/patch_layout.h"

#if defined(TESSERA_CORE_PATCH_HULL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PATCH_HULL_INL_H_
#undef TESSERA_CORE_PATCH_HULL_INL_H_
#else
#define TESSERA_CORE_PATCH_HULL_INL_H_
#endif

#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Rays of a register in the frame of a sub-patch.
struct RaysInFrame {
  Floats slope[2];  // p, q
  Floats at[2];     // o_a - p o_n, o_b - q o_n
  Floats size[2];   // N_a + |p| N_n, N_b + |q| N_n
  Floats distance;  // R + |t| S
  Floats flatness;  // S N_n / |d_n|
};

class PatchHull {
  using V = Floats;
  using M = MaskOf<V>;

 public:
  // Whether it is worth its time: for large parts of patches whose points are 16.
  static HWY_INLINE bool helps(const Patch& patch, const SubPatch& part) {
    constexpr float kCurved = 0.25f;
    return part.level_u + part.level_v <= 1 && part.reach[0] + part.reach[1] > kCurved &&
           !patch.is_rational && patch.degree_u == 3 && patch.degree_v == 3;
  }

  // Requires: helps().
  HWY_INLINE PatchHull(const Patch& patch, const SubPatch& part) {
    constexpr size_t kStep = kLaneCount < 16 ? kLaneCount : 16;
    V far = set<V>(0);
    for (size_t at = 0; at < 16; at += kStep) {
      V p[3] = {};
      hn::LoadInterleaved3(TagOf<V>(), patch.numbers + 3 * at, p[0], p[1], p[2]);
      for (int k = 0; k < 3; ++k) {
        p[k] = p[k] - part.centre[k];
        far = max(far, abs(p[k]));
      }
      for (int r = 0; r < 3; ++r)
        store(part.frame[r][0] * p[0] + part.frame[r][1] * p[1] + part.frame[r][2] * p[2],
              point_[r] + at);
    }
    far_ = greatest_lane(far);
  }

  // Which of the rays may meet it.
  HWY_INLINE M may_meet(const RaysInFrame& rays) const {
    const V off = rays.distance * kRoom + far_ * (rays.flatness * kRoom + (kRoom + 0x1p-17f));
    const V room[2] = {rays.size[0] * off, rays.size[1] * off};
    V low[4] = {}, high[4] = {};
    for (int p = 0; p < 16; ++p) {
      const V n = set<V>(point_[2][p]);
      const V x = mul_add(-n, rays.slope[0], set<V>(point_[0][p]));
      const V y = mul_add(-n, rays.slope[1], set<V>(point_[1][p]));
      const V seen[4] = {x, y, x + y, x - y};
      for (int k = 0; k < 4; ++k) {
        low[k] = p == 0 ? seen[k] : min(low[k], seen[k]);
        high[k] = p == 0 ? seen[k] : max(high[k], seen[k]);
      }
    }
    const V both = room[0] + room[1];
    const V at[4] = {rays.at[0], rays.at[1], rays.at[0] + rays.at[1], rays.at[0] - rays.at[1]};
    M is_out = room[0] < set<V>(0);
    for (int k = 0; k < 4; ++k) {
      const V rest = k < 2 ? room[k] : both;
      is_out = is_out || low[k] - at[k] > rest || at[k] - high[k] > rest;
    }
    return !is_out;
  }

 private:
  static constexpr float kRoom = 16 * kRoundoff;

  alignas(64) float point_[3][16];  // in the frame
  float far_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
