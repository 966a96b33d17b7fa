// Where a ray meets the plane of a triangle, by the same operations in every kernel and without
// fused multiply-adds, so that t is the same to the bit on every path and instruction set.
//
// N = (B - A) x (C - A), t = N.(A - O) / N.D. Each of the two products may cancel; where one does
// so badly, exact_hit() gives t instead. The tests for that are part of the definition of t, hence
// also the same everywhere. With u = 2^-24, c the largest sum of the sizes of the two products in a
// component of N, and |.| the sum of components: N is off by 3 u c, so N.D by less than 2^-22 c |D|
// and N.(A - O) by less than 2^-22 c |A - O|. Both are let pass where they are 2^9 times less than
// c |D| and c |A - O|: then they are good to 2^-13 of themselves, and t to 2^-12 at the very worst.
#include "slave/core/kernel/packet_layout.h"

#if defined(TESSERA_CORE_PLANE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_PLANE_INL_H_
#undef TESSERA_CORE_PLANE_INL_H_
#else
#define TESSERA_CORE_PLANE_INL_H_
#endif

#include "slave/core/kernel/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

struct Plane {
  float normal[3];
  float distance;   // N.(A - O)
  float steepness;  // t counts where |N.D| >= steepness * (|Dx| + |Dy| + |Dz|); NaN: nowhere
};

HWY_INLINE float abs_of(float v) { return __builtin_fabsf(v); }
HWY_INLINE float max_of(float a, float b) { return a > b ? a : b; }

template <int W>
HWY_INLINE Plane plane_of(const TriangleBlock<W>& block, size_t lane, const float* origin) {
  const auto at = [&](size_t k) { return block.vertex[k][lane]; };
  const float ax = at(0) - origin[0], ay = at(1) - origin[1], az = at(2) - origin[2];
  const float bx = at(3) - at(0), by = at(4) - at(1), bz = at(5) - at(2);
  const float cx = at(6) - at(0), cy = at(7) - at(1), cz = at(8) - at(2);
  const float yz = by * cz, zy = bz * cy, zx = bz * cx, xz = bx * cz, xy = bx * cy, yx = by * cx;
  Plane plane;
  plane.normal[0] = yz - zy;
  plane.normal[1] = zx - xz;
  plane.normal[2] = xy - yx;
  const float cross_size =
      max_of(abs_of(yz) + abs_of(zy), max_of(abs_of(zx) + abs_of(xz), abs_of(xy) + abs_of(yx)));
  const float reach = abs_of(ax) + abs_of(ay) + abs_of(az);
  plane.distance = (plane.normal[0] * ax + plane.normal[1] * ay) + plane.normal[2] * az;
  // The limits keep clear of overflow and of denormal numbers, where errors are not relative.
  const bool is_good = abs_of(plane.distance) * 0x1p9f >= cross_size * reach &&
                       cross_size > 0x1p-60f && cross_size < 0x1p60f && reach < 0x1p60f &&
                       abs_of(plane.distance) > 0x1p-100f;
  plane.steepness = is_good ? cross_size * 0x1p-9f : __builtin_nanf("");
  return plane;
}

// N.D and t of one ray; the kernels have the same in lanes. Returns: whether t counts.
HWY_INLINE bool plane_t(const Plane& plane, float dx, float dy, float dz, float size, float& speed,
                        float& t) {
  speed = (dx * plane.normal[0] + dy * plane.normal[1]) + dz * plane.normal[2];
  t = plane.distance / speed;
  return abs_of(speed) >= plane.steepness * size;
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
