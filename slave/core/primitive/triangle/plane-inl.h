// SPDX-License-Identifier: Apache-2.0
// Where a ray meets the plane of a triangle, by the same operations in every kernel, so that t is
// the same to the bit on every path and instruction set.
//
// N = (B - A) x (C - A), scaled by a power of two to about 1, t = N.(A - O) / N.D. Numerator and
// denominator are computed in double, rounded to float32, and divided there: differences of float32
// are exact in double but for exponents 29 apart, and no product of three leaves its range. What
// may cancel is N and the two products. With w = 2^-53 and c the largest sum of the sizes of the
// two products in a component of N, and |.| the sum of components, N.D is off by less than 8 w c
// |D| and N.(A - O) by less than 8 w c |A - O|. Both count where they are at least 2^-24 c |D| and
// 2^-24 c |A - O|: t is then good to 2^-25 and the three roundings to float32. Where one of them is
// less (a ray within some 2^-24 of the plane of a well-shaped triangle), or where they come near
// the ends of float32, exact_hit() gives t instead. These tests are part of the definition of t,
// hence the same everywhere.
#include "slave/core/primitive/triangle/triangle_layout.h"
#include "slave/core/simd/counts_layout.h"

#if defined(TESSERA_CORE_PLANE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PLANE_INL_H_
#undef TESSERA_CORE_PLANE_INL_H_
#else
#define TESSERA_CORE_PLANE_INL_H_
#endif

#include "slave/core/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Below that a quotient of float32 is not trusted; its reciprocal above.
constexpr float kPlaneLeast = 0x1p-100f;

struct Plane {
  double scale;  // of N
  double least;  // 2^-24 c, scaled
  double normal[3];
  float distance;   // N.(A - O)
  float steepness;  // t counts where |N.D| >= steepness * (|Dx| + |Dy| + |Dz|) + kPlaneLeast;
                    // NaN: nowhere
};

template <int W>
HWY_INLINE Plane plane_of(const TriangleBlock<W>& block, size_t lane, const float* origin) {
  const auto at = [&](size_t k) { return static_cast<double>(block.vertex[k][lane]); };
  const double ax = at(0) - static_cast<double>(origin[0]);
  const double ay = at(1) - static_cast<double>(origin[1]);
  const double az = at(2) - static_cast<double>(origin[2]);
  const double bx = at(3) - at(0), by = at(4) - at(1), bz = at(5) - at(2);
  const double cx = at(6) - at(0), cy = at(7) - at(1), cz = at(8) - at(2);
  const double yz = by * cz, zy = bz * cy, zx = bz * cx, xz = bx * cz, xy = bx * cy, yx = by * cx;
  const double size =
      max_of(abs_of(yz) + abs_of(zy), max_of(abs_of(zx) + abs_of(xz), abs_of(xy) + abs_of(yx)));
  Plane plane;
  const double scale = plane.scale = inverse_power(size);
  plane.normal[0] = (yz - zy) * scale;
  plane.normal[1] = (zx - xz) * scale;
  plane.normal[2] = (xy - yx) * scale;
  const double distance = (plane.normal[0] * ax + plane.normal[1] * ay) + plane.normal[2] * az;
  const double least = plane.least = size * scale * 0x1p-24;
  plane.distance = static_cast<float>(distance);
  const bool is_good = abs_of(distance) >= least * (abs_of(ax) + abs_of(ay) + abs_of(az)) &&
                       abs_of(plane.distance) >= kPlaneLeast &&
                       abs_of(plane.distance) <= 1 / kPlaneLeast;
  plane.steepness = is_good ? static_cast<float>(least) : __builtin_nanf("");
  return plane;
}

// N.D and t of one ray; FanBlock has the same in lanes. size: |D|. Returns: whether t counts.
HWY_INLINE bool plane_t(const Plane& plane, const float* direction, float size, float& speed,
                        float& t) {
  const double dx = static_cast<double>(direction[0]), dy = static_cast<double>(direction[1]),
               dz = static_cast<double>(direction[2]);
  speed = static_cast<float>((dx * plane.normal[0] + dy * plane.normal[1]) + dz * plane.normal[2]);
  t = plane.distance / speed;
  return abs_of(speed) >= plane.steepness * size + kPlaneLeast;
}

// N.D of a row of rays, as plane_t() has it.
template <class Rays>
HWY_INLINE typename Rays::V speed_of(const Rays& rays, const Plane& plane, size_t at) {
  const hn::CappedTag<double, Rays::kLanes> d;
  const hn::Rebind<float, decltype(d)> part;
  const auto speed = [&](size_t first) {
    const auto along = [&](size_t axis) {
      const auto component = hn::PromoteTo(d, hn::Load(part, rays.direction[axis] + first));
      return hn::Mul(component, hn::Set(d, plane.normal[axis]));
    };
    return hn::DemoteTo(part, hn::Add(hn::Add(along(0), along(1)), along(2)));
  };
  return halves(typename Rays::D(),
                [&](size_t half) { return speed(at + half * Rays::kLanes / 2); });
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
