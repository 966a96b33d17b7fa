// SPDX-License-Identifier: Apache-2.0
// Light of one VPL at many points: which of them may see it, and what those get that do (Benthin,
// thesis, section 9.3; Keller, "Instant radiosity", 1997).
//
// Threads. Works on the caller's memory.
#include "slave/core/light/gather_layout.h"

#if defined(TESSERA_CORE_VPL_GATHER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_VPL_GATHER_INL_H_
#undef TESSERA_CORE_VPL_GATHER_INL_H_
#else
#define TESSERA_CORE_VPL_GATHER_INL_H_
#endif

#include "slave/core/light/spot-inl.h"
#include "slave/core/simd/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// gamma(2) of common/math/rounding.h: a shadow ray's direction is rounded twice per component.
constexpr float kDirectionError = 2 * kRoundoff / (1 - 2 * kRoundoff);

// A shadow ray runs from the VPL to just above the point, both at their offsets beyond the exact
// planes of their triangles (surface_offset.h). It cannot meet either triangle where the other end
// is beyond that plane, too. With w the normal as computed, off by e, the other end at d and the
// triangle's own end at most `offset` off its plane, that is w.d > e |d| + offset, with the
// roundings of w.d, 4 u |d|. Triangles whose edges from A make a sine of 2^-8 or more have e <
// 2^-14 (slivers have no number here): 2^-12 |d|, kPlaneHorizon, is enough. At the VPL the test
// takes the ray's own direction, since the ray begins at the VPL's offset already. Other primitives
// have horizons of their own.
static_assert(kPlaneHorizon == 0x1p-12f);

HWY_INLINE bool is_surface(const LightPoint& light) {
  return light.kind == LightPointKind::kSurface || light.kind == LightPointKind::kEmitter;
}

// The greatest value of a * b, a and b in intervals.
HWY_INLINE float product_upper(float a_low, float a_high, float b_low, float b_high) {
  return max_of(max_of(a_low * b_low, a_low * b_high), max_of(a_high * b_low, a_high * b_high));
}

// Whether none of the points can get light, for all lie behind the VPL or have turned away from it.
// The bounds are sums of three products. One that is off by some roundings is off only where
// cosines are next to zero, hence the slack of 16 roundings of the largest term.
HWY_INLINE bool turned_away(const GatherPoints& p, const LightPoint& light) {
  float behind = 0, away = 0, size = 0, size_behind = 0;
  for (int a = 0; a < 3; ++a) {
    float low = p.lower[a] - light.position[a], high = p.upper[a] - light.position[a];
    if (light.kind == LightPointKind::kFar) low = high = light.normal[a];
    const float n = light.normal[a];
    behind += n > 0 ? n * high : n * low;
    size_behind += max_of(n * low, -n * low) + max_of(n * high, -n * high);
    away += product_upper(p.normal_lower[a], p.normal_upper[a], -high, -low);
    size += max_of(high, -high) + max_of(low, -low);
  }
  constexpr float kSlack = 16 * kRoundoff;
  if (away < -kSlack * size) return true;
  return is_surface(light) && behind < -kSlack * size_behind;
}

// Factor of the strength by the cosine at the light, before the clamp. cosine_light: of the angle
// between the light's normal and the way to the point.
HWY_INLINE Floats at_light(const LightPoint& light, Floats cosine_light) {
  if (is_surface(light)) return max(cosine_light, 0);
  if (light.kind != LightPointKind::kSpot) return set<Floats>(1);
  return spot_falloff(light.cos_inner, light.cos_outer, cosine_light);
}

inline void bound_points(GatherPoints& p) {
  using V = Floats;
  const int lanes = static_cast<int>(kLaneCount);
  const auto bound = [&](const float* x, float& lower, float& upper) {
    auto low = set<V>(x[0]), high = low;
    for (int i = 0; i < p.count; i += lanes) {
      const auto is_here = first_lanes<V>(static_cast<size_t>(p.count - i));
      const auto own = select(is_here, load<V>(x + i), low);
      low = min(low, own);
      high = max(high, select(is_here, own, high));
    }
    lower = least_lane(low);
    upper = greatest_lane(high);
  };
  for (int a = 0; a < 3; ++a) {
    bound(p.point[a], p.lower[a], p.upper[a]);
    bound(p.shading[a], p.normal_lower[a], p.normal_upper[a]);
  }
}

// Finds rays.strength and the shadow rays. kFar: light.position is a place far back along the rays,
// from which they are grouped. Returns: whether there are any rays.
inline bool begin_gather(const GatherPoints& p, const LightPoint& light, float clamp,
                         GatherRays& rays) {
  using V = Floats;
  using V3 = Vec3<V>;
  using VI = Ints;
  const int lanes = static_cast<int>(kLaneCount);
  rays.targets.count = 0;
  rays.is_origin_excluded = true;
  if (turned_away(p, light)) return false;
  const bool is_far = light.kind == LightPointKind::kFar;
  const auto clamp_to = set<V>(is_surface(light) ? clamp : __builtin_inff());
  const V3 from = same3<V>(light.position), axis = same3<V>(light.normal);
  int count = 0;
  for (int i = 0; i < p.count; i += lanes) {
    const auto at = static_cast<size_t>(i);
    const V3 point = load3<V>(p.point, at), normal = load3<V>(p.normal, at);
    const V3 to_light = is_far ? -axis : from - point;  // not normalised
    const V distance = length(to_light), inverse = is_far ? set<V>(1) : 1 / distance;
    const V cosine = dot(load3<V>(p.shading, at), to_light) * inverse;
    const V above = dot(normal, to_light);
    const V shed = at_light(light, -(dot(axis, to_light) * inverse));
    const V strength = min(max(cosine, 0) * inverse * (shed * inverse), clamp_to);
    const auto is_lit = strength > 0 && strength < __builtin_inff() && above > 0 &&
                        first_lanes<V>(static_cast<size_t>(p.count - i));
    store(zero_unless(is_lit, strength), rays.strength + i);
    const V own = load<V>(p.offset + i), off = is_far ? own : own + kDirectionError * distance;
    const V3 direction = point + normal * off - from;
    store_packed(direction.x, is_lit, rays.targets.direction[0] + count);
    store_packed(direction.y, is_lit, rays.targets.direction[1] + count);
    store_packed(direction.z, is_lit, rays.targets.direction[2] + count);
    const auto is_above_point = above > distance * load<V>(p.horizon + i) + (own + own);
    const auto is_above_light = dot(axis, direction) > (distance + off) * light.horizon;
    rays.is_origin_excluded &= is_all<V>(is_above_light || !is_lit);
    const auto primitive = load<VI>(reinterpret_cast<const int32_t*>(p.primitive) + i);
    store_packed(select(is_above_point, primitive, set<VI>(-1)), is_lit,
                 reinterpret_cast<int32_t*>(rays.excluded) + count);
    store_packed(counting_from<VI>(i), is_lit, rays.point + count);
    count += static_cast<int>(count_of<V>(is_lit));
  }
  rays.targets.count = count;
  return count > 0;
}

// Adds the VPL's light to the points by their strengths, which the caller has set to 0 in shadow.
inline void end_gather(const LightPoint& light, const GatherRays& rays, GatherPoints& p) {
  const int lanes = static_cast<int>(kLaneCount);
  for (int i = 0; i < p.count; i += lanes) {
    const auto strength = load<Floats>(rays.strength + i);
    for (int c = 0; c < 3; ++c) {
      const auto sum = load<Floats>(p.light[c] + i);
      store(sum + strength * light.rgb[c], p.light[c] + i);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
