// SPDX-License-Identifier: Apache-2.0
// 64 rays that leave one point, seen as one frustum.
//
// The main axis z is where the rays go; the origin is moved to 0 and every direction scaled to
// z = 1, so a ray is (u, v, 1) and the packet lies in [u_min, u_max] x [v_min, v_max].
//
// The best hit of a ray is known by its nearness 1/z, which is linear in u and v over a plane. It
// is kept as an interval that holds the nearness of t as it will be reported. Planar primitives
// compare intervals, and t itself is computed once, for what is nearest in the end (`pending`), or
// where two intervals overlap.
//
// Threads. One traversal owns one.
#include "slave/core/ray/packet_layout.h"

#if defined(TESSERA_CORE_FAN_RAYS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_FAN_RAYS_INL_H_
#undef TESSERA_CORE_FAN_RAYS_INL_H_
#else
#define TESSERA_CORE_FAN_RAYS_INL_H_
#endif

#include "slave/core/ray/packet_rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

struct FanRays : PacketRays {
  // A fan that gets through setup() is traced as one, however many steps it takes.
  static constexpr int kStepsMax = 0x7fffffff, kKdStepsMax = 0x7fffffff;

  static constexpr int kRaysLeast = 4;  // fewer are faster alone

  // Returns: whether the rays form a frustum: those that are valid go to one side of the main axis
  // and not far from it.
  bool setup(const FanPacket& rays);

  // Takes a hit of one ray, already decided. Returns: whether it is nearer than what the ray had.
  // Requires: the ray's best hit is not pending.
  template <bool kAny>
  bool take(size_t ray, float t, float t_min, uint32_t primitive);
  // Sets the t of a ray's best hit, which was pending or is new.
  HWY_INLINE void settle(size_t ray, float t);
  // Finds z_far and row_low; must be called after hits.
  HWY_INLINE void shorten();
  // Upper bounds of the best t of the rays from `at` on.
  HWY_INLINE V farthest(size_t at) const;

  float t_min = 0;
  int32_t excluded = -1;  // ExcludedPrimitives::at_origin
  float steepness = 0;    // largest sum of the sizes of u, v and 1 of a ray
  float widest[2];        // largest size of u, of v
  float nearest_min;      // a hit of less nearness is certainly not before t_min
  alignas(64) float ray_u[kPacketRays], ray_v[kPacketRays];
  alignas(64) float row_u[2][kRows], row_v[2][kRows];
  // Interval of the nearness of the best hit, or of t_max. Infinite for rays that look for nothing.
  alignas(64) float low[kPacketRays], high[kPacketRays];
  alignas(64) float row_low[kRows];  // least `low` of each row, where there are more than 4 rows
  // Where t of the best hit is not known yet: a number by which the primitives' test knows what was
  // hit. Else -1.
  alignas(64) int32_t pending[kPacketRays];

 private:
  // Relative error of a nearness computed from t is less than this: 4 roundings of t itself, and
  // one each of its product with z, of the quotient and of the bound.
  static constexpr float kNearSlack = 8 * kRoundoff;
  // Greatest `low`, for hits at t = 0, beside which there may be others at 0.
  static constexpr float kNearMax = 0x1.fffffep127f;

  static uint64_t valid_rays(const FanPacket& rays);
  bool setup_row(const FanPacket& rays, size_t row, uint64_t valid, size_t middle);
  void bound();
};

HWY_INLINE uint64_t FanRays::valid_rays(const FanPacket& rays) {
  uint64_t valid = 0;
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const V sum = sizes(rays.direction, at);
    const M is_valid = sum > 0 && sum < __builtin_inff() && load<V>(rays.t_max + at) >= rays.t_min;
    valid |= uint64_t{bits_of<V>(is_valid)} << at;
  }
  return valid & rays.active;
}

HWY_INLINE bool FanRays::setup(const FanPacket& rays) {
  const float* const o = rays.origin;
  if (!(abs_of(o[0]) + abs_of(o[1]) + abs_of(o[2]) < __builtin_inff())) return false;
  const uint64_t valid = valid_rays(rays);
  if (__builtin_popcountll(valid) < kRaysLeast || !(rays.t_min >= 0)) return false;
  const size_t middle = middle_of(valid);
  count = __builtin_popcountll(valid);
  if (rays.entry != nullptr) {
    set_axis(rays.entry->axis, rays.entry->side < 0);
  } else {
    aim(rays, middle);
  }
  for (int a = 0; a < 3; ++a) origin[a] = rays.origin[a];
  t_min = rays.t_min;
  excluded = static_cast<int32_t>(rays.excluded.at_origin);
  for (size_t r = 0; r < kRows; ++r) {
    if (!setup_row(rays, r, valid, middle)) return false;
  }
  bound();
  shorten();
  return true;
}

// Returns: whether the rays of the row are near the main axis.
HWY_INLINE bool FanRays::setup_row(const FanPacket& rays, size_t row, uint64_t valid,
                                   size_t middle) {
  const size_t at = row * kLanes;
  const V z = begin_row(rays, row, valid, middle), per_depth = 1 / z;
  const V u = load<V>(direction[kx] + at) * per_depth, v = load<V>(direction[ky] + at) * per_depth;
  if (!is_near(row, z, u, v)) return false;
  store(u, ray_u + at);
  store(v, ray_v + at);
  store(set<VI>(-1), pending + at);
  const V t_max = load<V>(best_t + at);
  const V near = per_depth / t_max;
  const M is_valid = t_max >= 0;
  const V least = min(near * (1 - kNearSlack) - kUnderflow, kNearMax);
  store(select(is_valid, least, set<V>(__builtin_inff())), low + at);
  store(select(is_valid, near * (1 + kNearSlack) + kUnderflow, set<V>(__builtin_inff())),
        high + at);
  return true;
}

HWY_INLINE void FanRays::bound() {
  const auto least = [](auto a, auto b) { return min(a, b); };
  const auto greatest = [](auto a, auto b) { return max(a, b); };
  const auto u = [&](size_t row) { return load<V>(ray_u + row * kLanes); };
  const auto v = [&](size_t row) { return load<V>(ray_v + row * kLanes); };
  fold_rows<kRows>(D(), u, least, row_u[0]);
  fold_rows<kRows>(D(), u, greatest, row_u[1]);
  fold_rows<kRows>(D(), v, least, row_v[0]);
  fold_rows<kRows>(D(), v, greatest, row_v[1]);
  float u_low = row_u[0][0], u_high = row_u[1][0], v_low = row_v[0][0], v_high = row_v[1][0];
  for (size_t r = 1; r < kRows; ++r) {
    u_low = min_of(u_low, row_u[0][r]);
    u_high = max_of(u_high, row_u[1][r]);
    v_low = min_of(v_low, row_v[0][r]);
    v_high = max_of(v_high, row_v[1][r]);
  }
  // Each bound is moved out by the roundings of u itself and of its product with z.
  const auto outward = [](float bound, float sign) {
    return bound + sign * abs_of(bound) * (8 * kRoundoff);
  };
  slope_u[0] = outward(u_low, -1);
  slope_u[1] = outward(u_high, 1);
  slope_v[0] = outward(v_low, -1);
  slope_v[1] = outward(v_high, 1);
  widest[0] = max_of(-slope_u[0], slope_u[1]);
  widest[1] = max_of(-slope_v[0], slope_v[1]);
  steepness = 1 + widest[0] + widest[1];
  nearest_min = __builtin_inff();
  if (!(t_min > 0)) return;
  V deepest = set<V>(0);
  for (size_t at = 0; at < kPacketRays; at += kLanes)
    deepest = max(deepest, abs(load<V>(direction[kz] + at)));
  nearest_min = 1 / (greatest_lane(deepest) * t_min) * (1 - kNearSlack) - kUnderflow;
}

template <bool kAny>
bool FanRays::take(size_t ray, float t, float least, uint32_t primitive) {
  const auto number = static_cast<int32_t>(primitive);
  if (!is_better(ray, t, least, number)) return false;
  best[ray] = number;
  if (kAny) {
    best_t[ray] = -__builtin_inff();
    low[ray] = high[ray] = __builtin_inff();
  } else {
    settle(ray, t);
  }
  return true;
}

HWY_INLINE void FanRays::settle(size_t ray, float t) {
  best_t[ray] = t;
  pending[ray] = -1;
  const float near = 1 / abs_of(direction[kz][ray] * t);  // t may be -0
  low[ray] = min_of(near * (1 - kNearSlack) - kUnderflow, kNearMax);
  high[ray] = near * (1 + kNearSlack) + kUnderflow;
}

HWY_INLINE void FanRays::shorten() {
  const auto least = [](auto a, auto b) { return min(a, b); };
  float lowest;
  if constexpr (kRows == 4) {
    const auto row = [&](size_t r) { return load<V>(low + r * kLanes); };
    lowest = least_lane(least(least(row(0), row(1)), least(row(2), row(3))));
  } else {
    fold_rows<kRows>(
        D(), [&](size_t r) { return load<V>(low + r * kLanes); }, least, row_low);
    lowest = row_low[0];
    for (size_t r = 1; r < kRows; ++r) lowest = min_of(lowest, row_low[r]);
  }
  if (lowest > 0)
    z_far = lowest < __builtin_inff() ? 1 / lowest * (1 + kTimeSlack) : -__builtin_inff();
  else
    z_far = __builtin_inff();
}

HWY_INLINE FanRays::V FanRays::farthest(size_t at) const {
  const V near = load<V>(low + at), infinity = set<V>(__builtin_inff());
  const V t = 1 / (near * abs(load<V>(direction[kz] + at))) * (1 + kNearSlack);
  return select(near > 0, select(near < infinity, t, -infinity), infinity);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
