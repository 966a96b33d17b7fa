// SPDX-License-Identifier: Apache-2.0
// 64 rays that leave one point, seen as one frustum.
//
// The main axis z is where the rays go; the origin is moved to 0 and every direction scaled to
// z = 1, so a ray is (u, v, 1) and the packet lies in [u_min, u_max] x [v_min, v_max].
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
  // A fan that gets through setup() is traced as one.
  static constexpr int kStepsMax = 0x7fffffff, kKdStepsMax = 0x7fffffff;

  static constexpr int kRaysLeast = 4;  // fewer are faster alone

  // Returns: whether the rays form a frustum: those that are valid go to one side of the main axis
  // and not far from it.
  bool setup(const FanPacket& rays);

  float t_min = 0;
  int32_t excluded = -1;  // ExcludedPrimitives::at_origin
  float steepness = 0;    // largest sum of the sizes of u, v and 1 of a ray
  alignas(64) float ray_u[kPacketRays], ray_v[kPacketRays];
  alignas(64) float row_u[2][kRows], row_v[2][kRows];

 private:
  static uint64_t valid_rays(const FanPacket& rays);
  bool setup_row(const FanPacket& rays, size_t row, uint64_t valid, size_t middle);
  void bound();
};

HWY_INLINE uint64_t FanRays::valid_rays(const FanPacket& rays) {
  const D d;
  uint64_t valid = 0;
  for (size_t at = 0; at < kPacketRays; at += kLanes) {
    const V sum = sizes(rays.direction, at);
    auto is_valid = hn::And(hn::Gt(sum, hn::Zero(d)), hn::Lt(sum, hn::Inf(d)));
    is_valid = hn::And(is_valid, hn::Ge(hn::Load(d, rays.t_max + at), hn::Set(d, rays.t_min)));
    valid |= uint64_t{bits_of(d, is_valid)} << at;
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
  set_depths();
  return true;
}

// Returns: whether the rays of the row are near the main axis.
HWY_INLINE bool FanRays::setup_row(const FanPacket& rays, size_t row, uint64_t valid,
                                   size_t middle) {
  const D d;
  const size_t at = row * kLanes;
  V u, v;
  if (!begin_row(rays, row, valid, middle, u, v)) return false;
  hn::Store(u, d, ray_u + at);
  hn::Store(v, d, ray_v + at);
  hn::Store(hn::Zero(d), d, start + at);
  return true;
}

HWY_INLINE void FanRays::bound() {
  const D d;
  const auto least = [](auto a, auto b) { return hn::Min(a, b); };
  const auto greatest = [](auto a, auto b) { return hn::Max(a, b); };
  const auto u = [&](size_t row) { return hn::Load(d, ray_u + row * kLanes); };
  const auto v = [&](size_t row) { return hn::Load(d, ray_v + row * kLanes); };
  fold_rows<kRows>(d, u, least, row_u[0]);
  fold_rows<kRows>(d, u, greatest, row_u[1]);
  fold_rows<kRows>(d, v, least, row_v[0]);
  fold_rows<kRows>(d, v, greatest, row_v[1]);
  float u_low = row_u[0][0], u_high = row_u[1][0], v_low = row_v[0][0], v_high = row_v[1][0];
  for (size_t r = 1; r < kRows; ++r) {
    u_low = min_of(u_low, row_u[0][r]);
    u_high = max_of(u_high, row_u[1][r]);
    v_low = min_of(v_low, row_v[0][r]);
    v_high = max_of(v_high, row_v[1][r]);
  }
  // Each bound moved out by the roundings of u itself and of its product with z.
  const auto outward = [](float bound, float sign) {
    return bound + sign * abs_of(bound) * (8 * kRoundoff);
  };
  slope_u[0] = outward(u_low, -1);
  slope_u[1] = outward(u_high, 1);
  slope_v[0] = outward(v_low, -1);
  slope_v[1] = outward(v_high, 1);
  steepness = 1 + max_of(-slope_u[0], slope_u[1]) + max_of(-slope_v[0], slope_v[1]);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
