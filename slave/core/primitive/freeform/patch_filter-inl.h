// SPDX-License-Identifier: Apache-2.0
// Which rays may meet a sub-patch: one test of its parallelepiped, in float32, a ray per lane.
//
// A ray passes the plane n = 0 of the frame at x = o_a - p o_n, p = d_a / d_n, after the time
// t = -o_n / d_n; all it meets of the sub-patch is within reach_a + |p| reach_n of x, by x, and
// so by y, and within reach_n / |d_n| of t (patch_decision-inl.h). A ray farther away misses
// by the decision as well, which asks for less room.
//
// Roundings, with u = 2^-24, N_r the sum of a row of the frame by size, S that of the direction, R
// the farthest coordinate of the origin from the centre: o_r is off by 4 u N_r R at most (a
// difference, a product, two sums; for a fan it is made in double and off by u), d_r by 3 u N_r S.
// Where |d_n| > 2^6 u N_n S, p is off by 4 u (N_a + |p| N_n) S / |d_n| and 2 u |p|; times |o_n| =
// |t| |d_n| that is 4 u (N_a + |p| N_n) |t| S and 2 u |p| N_n R. With roundings of p o_n and of the
// difference x is off by less than 8 u (N_a + |p| N_n) (R + |t| S); twice that is allowed. Of t,
// o_n makes 4 u N_n R / |d_n| and d_n 4 u N_n |t| S / |d_n|, within the same room. Rays for which
// any of this is not a number, or d_n is too small, stay.
//
// Threads. Pure functions.
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_PATCH_FILTER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PATCH_FILTER_INL_H_
#undef TESSERA_CORE_PATCH_FILTER_INL_H_
#else
#define TESSERA_CORE_PATCH_FILTER_INL_H_
#endif

#include "slave/core/primitive/freeform/fan_rows-inl.h"
#include "slave/core/primitive/freeform/patch_hull-inl.h"
#include "slave/core/ray/bundle_rays-inl.h"
#include "slave/core/ray/fan_rays-inl.h"
#include "slave/core/ray/one_ray-inl.h"
#include "slave/core/simd/real-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

HWY_INLINE void origin_of(const FanRays& rays, size_t, float* to) {
  for (int a = 0; a < 3; ++a) to[a] = rays.origin[a];
}
HWY_INLINE void origin_of(const BundleRays& rays, size_t ray, float* to) {
  for (int a = 0; a < 3; ++a) to[a] = rays.from[a][ray];
}
HWY_INLINE float least_t(const FanRays& rays, size_t) { return rays.t_min; }
HWY_INLINE float least_t(const BundleRays& rays, size_t ray) { return rays.t_min[ray]; }
HWY_INLINE Floats least_ts(const FanRays& rays, size_t) { return set<Floats>(rays.t_min); }
HWY_INLINE Floats least_ts(const BundleRays& rays, size_t at) {
  return load<Floats>(rays.t_min + at);
}

struct NothingMore {
  HWY_INLINE MaskOf<Floats> may_meet(const RaysInFrame& rays) const {
    return rays.distance == rays.distance;
  }
};

// Spans of a widened border, which are nearly parabolas in their frame: the test of passes_by() in
// fat_border.cpp, with the room of this filter in place of that of doubles. x and y are off by
// 8 u (N_a + |p| N_n) (R + |t| S), of which twice is allowed; the parabola has four roundings.
class BorderBend {
  using V = Floats;

 public:
  // Requires: the sub-patch is a span of a border.
  HWY_INLINE explicit BorderBend(const SubPatch& part)
      : bend_(part.second[2][1]),
        away_(part.second[2][2]),
        reach_(part.reach[2]),
        far_(1 + part.reach[0]) {}

  HWY_INLINE MaskOf<V> may_meet(const RaysInFrame& rays) const {
    const V x = rays.at[0], y = rays.at[1], off = rays.distance * PatchFilterRoom::kRoom;
    const V away_x = abs(rays.slope[0]) * reach_ + rays.size[0] * off;
    const V away_y = abs(rays.slope[1]) * reach_ + rays.size[1] * off;
    const V steepest = 2 * abs_of(bend_) * max(abs(x), set<V>(far_));
    const V curve = bend_ * (x * x - 0.5f);
    const V roundings = (8 * kRoundoff) * (abs(curve) + abs(y) + abs_of(bend_));
    return !(abs(y - curve) > away_ + away_y + (steepest * away_x + roundings));
  }

 private:
  const float bend_, away_, reach_, far_;
};

// Rays: FanRays or BundleRays, or others that are as a bundle and have
//   Floats farther(size_t at)   by how much `distance` is larger, of the rays from `at` on:
//                               room that comes on top, over kRoom.
template <class Rays>
class PatchFilter : PatchFilterRoom {
  using V = Floats;
  using M = MaskOf<V>;

 public:
  HWY_INLINE PatchFilter(const Rays& rays, const SubPatch& part) : rays_(rays), part_(part) {
    for (int r = 0; r < 3; ++r)
      norm_[r] = abs_of(part.frame[r][0]) + abs_of(part.frame[r][1]) + abs_of(part.frame[r][2]);
    set_origin(rays);
  }

  // Returns: the bits of rows of which some ray may meet it.
  // Requires: it has a frame, and kHasRows<Rays>.
  HWY_INLINE uint64_t possible_rows(const FanRows& rows) const {
    return rows.possible(rays_, part_, origin_, norm_, reach_);
  }
  // Returns: the bits of the rays from `at` on that may meet it. Requires: it has a frame.
  // more: what else is known of the sub-patch, a PatchHull, a BorderBend or NothingMore.
  template <class More>
  HWY_INLINE uint32_t possible(size_t at, const More& more) const {
    V o[3] = {}, d[3] = {}, reach = set<V>(reach_);
    load_origin(rays_, at, o, reach);
    const V x = load<V>(rays_.direction[0] + at), y = load<V>(rays_.direction[1] + at);
    const V z = load<V>(rays_.direction[2] + at);
    for (int r = 0; r < 3; ++r)
      d[r] = mul_add(set<V>(part_.frame[r][2]), z,
                     mul_add(set<V>(part_.frame[r][1]), y, x * part_.frame[r][0]));
    const V length = abs(x) + abs(y) + abs(z);
    const V inverse = 1 / d[2], t = -o[2] * inverse;
    const V room = (reach + abs(t) * length) * kRoom;
    const V away = part_.reach[2] + room * norm_[2];
    const V after = away * abs(inverse);
    const V best = rays_.farthest(at), least = least_ts(rays_, at);
    M is_out = t - after > best + abs(best) * kLimitSlack;
    is_out = is_out || t + after < least - abs(least) * kLimitSlack;
    RaysInFrame seen;
    for (int c = 0; c < 2; ++c) {
      seen.slope[c] = d[c] * inverse;
      seen.at[c] = o[c] - seen.slope[c] * o[2];
      const V size = abs(seen.slope[c]);
      const V allowed = size * away + (room * norm_[c] + (kBorder + part_.reach[c]));
      seen.size[c] = size * norm_[2] + norm_[c];
      is_out = is_out || abs(seen.at[c]) > allowed;
    }
    // Where d_n is too small the test says nothing; rays that look for nothing stay out.
    const M is_flat = !(abs(d[2]) > length * (kTooFlat * norm_[2]));
    const M is_over = best < least, stays = and_not(is_over, is_flat || !is_out);
    if (is_none<V>(stays)) return 0;
    seen.distance = reach + abs(t) * length;
    seen.flatness = length * (norm_[2] * abs(inverse));
    return bits_of<V>(stays && (is_flat || more.may_meet(seen)));
  }

 private:
  HWY_INLINE void set_origin(const FanRays& rays) {
    double from[3];
    double far = 0;
    for (int k = 0; k < 3; ++k) {
      from[k] = static_cast<double>(rays.origin[k]) - static_cast<double>(part_.centre[k]);
      far = far < __builtin_fabs(from[k]) ? __builtin_fabs(from[k]) : far;
    }
    for (int r = 0; r < 3; ++r) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += static_cast<double>(part_.frame[r][k]) * from[k];
      origin_[r] = static_cast<float>(sum);
    }
    reach_ = static_cast<float>(far) * (1 + kRoundoff);
  }
  template <class Others>
  HWY_INLINE void set_origin(const Others&) {}
  HWY_INLINE void load_origin(const FanRays&, size_t, V (&o)[3], V&) const {
    for (int r = 0; r < 3; ++r) o[r] = set<V>(origin_[r]);
  }
  template <class Others>
  HWY_INLINE void load_origin(const Others& rays, size_t at, V (&o)[3], V& reach) const {
    V from[3] = {};
    for (int k = 0; k < 3; ++k) from[k] = load<V>(rays.from[k] + at) - part_.centre[k];
    reach = max(max(abs(from[0]), abs(from[1])), abs(from[2]));
    if constexpr (requires { rays.farther(at); }) reach = reach + rays.farther(at);
    for (int r = 0; r < 3; ++r)
      o[r] =
          from[0] * part_.frame[r][0] + from[1] * part_.frame[r][1] + from[2] * part_.frame[r][2];
  }

  const Rays& rays_;
  const SubPatch& part_;
  float norm_[3] = {}, origin_[3] = {}, reach_ = 0;
};

// The same test of one ray, without a branch. Its roundings are those of a bundle's.
class PatchRayFilter : PatchFilterRoom {
 public:
  // Ray: OneRay, or what has its members that are asked for, and
  //   float farther   as of PatchFilter.
  // Returns: whether the ray may meet the sub-patch. Requires: it has a frame.
  template <class Ray>
  static HWY_INLINE bool is_possible(const Ray& ray, const SubPatch& part) {
    float from[3], o[3], d[3], norm[3];
    for (int k = 0; k < 3; ++k) from[k] = ray.origin[k] - part.centre[k];
    for (int r = 0; r < 3; ++r) {
      const float* const row = part.frame[r];
      o[r] = from[0] * row[0] + from[1] * row[1] + from[2] * row[2];
      d[r] = row[0] * ray.direction[0] + row[1] * ray.direction[1] + row[2] * ray.direction[2];
      norm[r] = abs_of(row[0]) + abs_of(row[1]) + abs_of(row[2]);
    }
    float reach = max_of(max_of(abs_of(from[0]), abs_of(from[1])), abs_of(from[2]));
    if constexpr (requires { ray.farther; }) reach += ray.farther;
    const float inverse = 1 / d[2], t = -o[2] * inverse;
    const float room = (reach + abs_of(t) * ray.size) * kRoom;
    const float away = part.reach[2] + room * norm[2];
    const float after = away * abs_of(inverse);
    bool is_out = t - after > ray.best_t + abs_of(ray.best_t) * kLimitSlack;
    is_out |= t + after < ray.t_min - abs_of(ray.t_min) * kLimitSlack;
    for (int c = 0; c < 2; ++c) {
      const float slope = d[c] * inverse, at_plane = abs_of(o[c] - slope * o[2]);
      is_out |= at_plane > abs_of(slope) * away + (room * norm[c] + (kBorder + part.reach[c]));
    }
    const bool is_flat = !(abs_of(d[2]) > ray.size * (kTooFlat * norm[2]));
    return is_flat | !is_out;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
