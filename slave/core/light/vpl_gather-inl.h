// SPDX-License-Identifier: Apache-2.0
// Light of one VPL at many points: who may see it, and what those get who do (Benthin, thesis,
// section 9.3; Keller, "Instant radiosity", 1997).
//
// Threads. Works on the caller's memory.
#include "slave/core/light/gather_layout.h"

#if defined(TESSERA_CORE_VPL_GATHER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_VPL_GATHER_INL_H_
#undef TESSERA_CORE_VPL_GATHER_INL_H_
#else
#define TESSERA_CORE_VPL_GATHER_INL_H_
#endif

#include "slave/core/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

using GatherTag = hn::CappedTag<float, 16>;

// gamma(2) of common/math/rounding.h: a shadow ray's direction is rounded twice per component.
constexpr float kDirectionError = 2 * kRoundoff / (1 - 2 * kRoundoff);

// A shadow ray runs from the VPL to just above the point, both at their offsets beyond the exact planes
// of their triangles (surface_offset.h). It cannot meet either triangle where the other end is beyond
// that plane, too. With w the normal as computed, off by e, the other end at d and the triangle's own
// end at most `offset` off its plane, that is w.d > e |d| + offset, with the roundings of w.d, 4 u |d|.
// Triangles whose edges from A make a sine of 2^-8 or more have e < 2^-14 (slivers have no number here):
// 2^-12 |d| is enough. At the VPL the ray's own direction is asked, which begins at its offset already.
constexpr float kApart = 0x1p-12f;

HWY_INLINE float larger(float a, float b) { return a > b ? a : b; }

HWY_INLINE bool is_surface(const LightPoint& light) {
  return light.kind == LightPointKind::kSurface || light.kind == LightPointKind::kEmitter;
}

// The greatest value of a * b, a and b in intervals.
HWY_INLINE float product_upper(float a_low, float a_high, float b_low, float b_high) {
  return larger(larger(a_low * b_low, a_low * b_high), larger(a_high * b_low, a_high * b_high));
}

// Whether none of the points can get light, for all lie behind the VPL or have turned away from it.
// Sums of three products: a bound that is off by some roundings is off only where cosines are next
// to zero, hence the slack of 16 roundings of the largest term.
HWY_INLINE bool turned_away(const GatherPoints& p, const LightPoint& light) {
  float behind = 0, away = 0, size = 0, size_behind = 0;
  for (int a = 0; a < 3; ++a) {
    float low = p.lower[a] - light.position[a], high = p.upper[a] - light.position[a];
    if (light.kind == LightPointKind::kFar) low = high = light.normal[a];
    const float n = light.normal[a];
    behind += n > 0 ? n * high : n * low;
    size_behind += larger(n * low, -n * low) + larger(n * high, -n * high);
    away += product_upper(p.normal_lower[a], p.normal_upper[a], -high, -low);
    size += larger(high, -high) + larger(low, -low);
  }
  constexpr float kSlack = 16 * kRoundoff;
  if (away < -kSlack * size) return true;
  return is_surface(light) && behind < -kSlack * size_behind;
}

// Of the cosine at the light, before the clamp: `cosine_light` is that of the angle between the
// light's normal and the way to the point.
template <class V>
HWY_INLINE V at_light(const LightPoint& light, V cosine_light) {
  const GatherTag d;
  if (is_surface(light)) return hn::Max(cosine_light, hn::Zero(d));
  if (light.kind != LightPointKind::kSpot) return hn::Set(d, 1);
  // spot_falloff() in light_sampling.h has the same.
  if (!(light.cos_inner > light.cos_outer))
    return hn::IfThenElseZero(hn::Ge(cosine_light, hn::Set(d, light.cos_inner)), hn::Set(d, 1));
  const auto x = hn::Div(hn::Sub(cosine_light, hn::Set(d, light.cos_outer)),
                         hn::Set(d, light.cos_inner - light.cos_outer));
  const auto t = hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, 1));
  return hn::Mul(t, t);
}

inline void bound_points(GatherPoints& p) {
  const GatherTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto bound = [&](const float* x, float& lower, float& upper) {
    auto low = hn::Set(d, x[0]), high = low;
    for (int i = 0; i < p.count; i += lanes) {
      const auto is_here = hn::FirstN(d, static_cast<size_t>(p.count - i));
      const auto own = hn::IfThenElse(is_here, hn::Load(d, x + i), low);
      low = hn::Min(low, own);
      high = hn::Max(high, hn::IfThenElse(is_here, own, high));
    }
    lower = hn::GetLane(hn::MinOfLanes(d, low));
    upper = hn::GetLane(hn::MaxOfLanes(d, high));
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
  const GatherTag d;
  const hn::RebindToSigned<GatherTag> di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  rays.targets.count = 0;
  rays.is_origin_excluded = true;
  if (turned_away(p, light)) return false;
  const bool is_far = light.kind == LightPointKind::kFar;
  const auto zero = hn::Zero(d), one = hn::Set(d, 1);
  const auto clamp_to = hn::Set(d, is_surface(light) ? clamp : __builtin_inff());
  const auto lx = hn::Set(d, light.position[0]), ly = hn::Set(d, light.position[1]),
             lz = hn::Set(d, light.position[2]);
  const auto wx = hn::Set(d, light.normal[0]), wy = hn::Set(d, light.normal[1]),
             wz = hn::Set(d, light.normal[2]);
  int count = 0;
  for (int i = 0; i < p.count; i += lanes) {
    const auto px = hn::Load(d, p.point[0] + i), py = hn::Load(d, p.point[1] + i),
               pz = hn::Load(d, p.point[2] + i);
    const auto nx = hn::Load(d, p.normal[0] + i), ny = hn::Load(d, p.normal[1] + i),
               nz = hn::Load(d, p.normal[2] + i);
    const auto sx = hn::Load(d, p.shading[0] + i), sy = hn::Load(d, p.shading[1] + i),
               sz = hn::Load(d, p.shading[2] + i);
    const auto dot3 = [](auto ax, auto ay, auto az, auto bx, auto by, auto bz) {
      return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz));
    };
    // To the light, not normalised.
    const auto ax = is_far ? hn::Neg(wx) : hn::Sub(lx, px),
               ay = is_far ? hn::Neg(wy) : hn::Sub(ly, py),
               az = is_far ? hn::Neg(wz) : hn::Sub(lz, pz);
    const auto distance2 = dot3(ax, ay, az, ax, ay, az), distance = hn::Sqrt(distance2);
    const auto inverse = is_far ? one : hn::Div(one, distance);
    const auto cosine = hn::Mul(dot3(sx, sy, sz, ax, ay, az), inverse);
    const auto above = dot3(nx, ny, nz, ax, ay, az);
    const auto cosine_light = hn::Neg(hn::Mul(dot3(wx, wy, wz, ax, ay, az), inverse));
    const auto shed = at_light(light, cosine_light);
    const auto spread = hn::Mul(hn::Mul(hn::Max(cosine, zero), inverse), hn::Mul(shed, inverse));
    const auto strength = hn::Min(spread, clamp_to);
    const auto is_lit =
        hn::And(hn::And(hn::Gt(strength, zero), hn::Lt(strength, hn::Set(d, __builtin_inff()))),
                hn::And(hn::Gt(above, zero), hn::FirstN(d, static_cast<size_t>(p.count - i))));
    hn::Store(hn::IfThenElseZero(is_lit, strength), d, rays.strength + i);
    const auto off =
        is_far ? hn::Load(d, p.offset + i)
               : hn::Add(hn::Load(d, p.offset + i), hn::Mul(hn::Set(d, kDirectionError), distance));
    const auto tx = hn::Sub(hn::Add(px, hn::Mul(nx, off)), lx),
               ty = hn::Sub(hn::Add(py, hn::Mul(ny, off)), ly),
               tz = hn::Sub(hn::Add(pz, hn::Mul(nz, off)), lz);
    store_packed(d, tx, is_lit, rays.targets.direction[0] + count);
    store_packed(d, ty, is_lit, rays.targets.direction[1] + count);
    store_packed(d, tz, is_lit, rays.targets.direction[2] + count);
    const auto own = hn::Load(d, p.offset + i), apart = hn::Set(d, kApart);
    const auto is_above_point = hn::Gt(above, hn::Add(hn::Mul(distance, apart), hn::Add(own, own)));
    const auto is_above_light =
        hn::Gt(dot3(wx, wy, wz, tx, ty, tz), hn::Mul(hn::Add(distance, off), apart));
    rays.is_origin_excluded &= hn::AllTrue(d, hn::Or(is_above_light, hn::Not(is_lit)));
    const auto triangle = hn::Load(di, reinterpret_cast<const int32_t*>(p.triangle) + i);
    store_packed(di, hn::IfThenElse(hn::RebindMask(di, is_above_point), triangle, hn::Set(di, -1)),
                 hn::RebindMask(di, is_lit), reinterpret_cast<int32_t*>(rays.excluded) + count);
    store_packed(di, hn::Iota(di, i), hn::RebindMask(di, is_lit), rays.point + count);
    count += static_cast<int>(hn::CountTrue(d, is_lit));
  }
  rays.targets.count = count;
  return count > 0;
}

// Adds what the points get whose strength is left.
inline void end_gather(const LightPoint& light, const GatherRays& rays, GatherPoints& p) {
  const GatherTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int i = 0; i < p.count; i += lanes) {
    const auto strength = hn::Load(d, rays.strength + i);
    for (int c = 0; c < 3; ++c) {
      const auto sum = hn::Load(d, p.light[c] + i);
      hn::Store(hn::Add(sum, hn::Mul(strength, hn::Set(d, light.rgb[c]))), d, p.light[c] + i);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
