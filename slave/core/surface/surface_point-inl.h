// SPDX-License-Identifier: Apache-2.0
// surface_point() of surface/surface_offset.h in lanes, to the bit: the bounds derived there hold.
// Threads. Pure functions.
#if defined(TESSERA_CORE_SURFACE_POINT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_SURFACE_POINT_INL_H_
#undef TESSERA_CORE_SURFACE_POINT_INL_H_
#else
#define TESSERA_CORE_SURFACE_POINT_INL_H_
#endif

#include "slave/core/simd/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

HWY_INLINE constexpr float gamma_of(int n) {
  const float nu = static_cast<float>(n) * kRoundoff;
  return nu / (1 - nu);
}

template <class Tag>
struct OffsetPoint {
  Vec3<Tag> point;
  hn::Vec<Tag> offset;  // along the unit normal
};

// A + u B + v C of a triangle with edges B and C from A.
template <class Tag, class V = hn::Vec<Tag>>
HWY_INLINE OffsetPoint<Tag> surface_point(Tag d, Vec3<Tag> a, Vec3<Tag> edge_b, Vec3<Tag> edge_c,
                                          Vec3<Tag> normal, V u, V v) {
  const Vec3<Tag> along_b = edge_b * u, along_c = edge_c * v;
  const Vec3<Tag> within = along_b + along_c;
  const Vec3<Tag> point = a + within;
  const Vec3<Tag> error = (abs(along_b) + abs(along_c)) * hn::Set(d, gamma_of(3)) +
                          abs(point) * hn::Set(d, gamma_of(4));
  const V reach = hn::Max(hn::Max(largest(abs(within)), largest(abs(edge_b - within))),
                          largest(abs(edge_c - within)));
  return {point, hn::Add(dot(abs(normal), error), hn::Mul(hn::Set(d, 16 * kRoundoff), reach))};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
