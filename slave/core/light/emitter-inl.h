// SPDX-License-Identifier: Apache-2.0
// Light samples of triangles that emit, one surface per lane.
//
// Threads. Works on the caller's memory.
#include "slave/core/light/emitter_layout.h"

#if defined(TESSERA_CORE_EMITTER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_EMITTER_INL_H_
#undef TESSERA_CORE_EMITTER_INL_H_
#else
#define TESSERA_CORE_EMITTER_INL_H_
#endif

#include "slave/core/surface/surface_point-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// Coordinates of a point that is uniform on the triangle (Osada et al., "Shape distributions",
// 2002, section 4.2); the mapping keeps strata. x, y: in the unit square. T: float, or Floats.
template <class T>
struct TrianglePlace {
  T u, v;
};
template <class T>
TESSERA_INLINE TrianglePlace<T> point_on_triangle(T x, T y) {
  const T root = sqrt(x);
  return {root * (1 - y), root * y};
}

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#ifndef TESSERA_PLAIN_TEXT

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class EmitterKernel {
  using V = Floats;
  using V3 = Vec3<V>;

 public:
  EmitterKernel(const LitSurfaces& surfaces, EmitterSamples& samples)
      : surfaces_(surfaces), e_(samples) {}

  void run() {
    for (int i = 0; i < e_.count; i += static_cast<int>(kLaneCount)) sample(static_cast<size_t>(i));
  }

 private:
  HWY_INLINE void sample(size_t at) {
    const auto [u, v] = point_on_triangle(load<V>(e_.square[0] + at), load<V>(e_.square[1] + at));
    const V3 emitter_normal = load3<V>(e_.emitter_normal, at);
    const SurfacePoint<V> on = surface_point(load3<V>(e_.a, at), load3<V>(e_.edge_b, at),
                                             load3<V>(e_.edge_c, at), emitter_normal, u, v);
    const V3 point = load3<V>(surfaces_.point, at), normal = load3<V>(surfaces_.normal, at);
    const V3 away = on.point - point;
    const V distance2 = dot(away, away), distance = sqrt(distance2);
    const V3 to_light = away * (1 / distance);
    const V cosine_light = -dot(emitter_normal, to_light);  // one-sided
    const V cosine = dot(load3<V>(surfaces_.shading_normal, at), to_light);
    // An interpolated normal must not let light through the surface.
    const auto is_lit = cosine_light > 0 && cosine > 0 && dot(normal, to_light) > 0;
    const V area = load<V>(e_.area + at), chance = load<V>(e_.chance + at);
    const V whole = cosine * cosine_light * area / distance2;
    const V weight = 1 / (e_.samples * chance);
    const V strength = kInvPi * whole * weight;
    store(zero_unless(is_lit, strength), e_.strength + at);
    const V pdf = chance / area * distance2 / cosine_light;
    store(pdf, e_.pdf + at);
    // The ray ends at a point moved off the emitter as its start is moved off the surface, so that
    // it cannot reach the emitter itself; the direction rounds once per component.
    const V off = on.offset + gamma_of(2) * distance;
    const V3 start = point + normal * load<V>(surfaces_.offset + at);
    store3(on.point + emitter_normal * off - start, e_.direction, at);
    store3(start, e_.start, at);
    store3(to_light, e_.to_light, at);
    store(u, e_.u + at);
    store(v, e_.v + at);
  }

  const LitSurfaces& surfaces_;
  EmitterSamples& e_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // TESSERA_PLAIN_TEXT

#endif  // per-target include guard
