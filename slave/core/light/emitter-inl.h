// SPDX-License-Identifier: Apache-2.0
// Samples of the light that triangles shed, a surface to a lane.
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

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class EmitterKernel {
  using D = hn::CappedTag<float, 16>;
  using V = hn::Vec<D>;
  using V3 = Vec3<D>;

 public:
  EmitterKernel(const LitSurfaces& surfaces, EmitterSamples& samples)
      : surfaces_(surfaces), e_(samples) {}

  void run() {
    for (int i = 0; i < e_.count; i += static_cast<int>(hn::Lanes(D())))
      sample(static_cast<size_t>(i));
  }

 private:
  // Uniform on the triangle (Osada et al., "Shape distributions", 2002, section 4.2); keeps strata.
  HWY_INLINE void sample(size_t at) {
    const D d;
    const V one = hn::Set(d, 1), zero = hn::Zero(d);
    const V y = hn::Load(d, e_.square[1] + at), root = hn::Sqrt(hn::Load(d, e_.square[0] + at));
    const V u = hn::Mul(root, hn::Sub(one, y)), v = hn::Mul(root, y);
    const V3 emitter_normal = load3(d, e_.emitter_normal, at);
    const OffsetPoint<D> on = surface_point(d, load3(d, e_.a, at), load3(d, e_.edge_b, at),
                                            load3(d, e_.edge_c, at), emitter_normal, u, v);
    const V3 point = load3(d, surfaces_.point, at), normal = load3(d, surfaces_.normal, at);
    const V3 away = on.point - point;
    const V distance2 = dot(away, away), distance = hn::Sqrt(distance2);
    const V3 to_light = away * hn::Div(one, distance);
    const V cosine_light = hn::Neg(dot(emitter_normal, to_light));  // one-sided
    const V cosine = dot(load3(d, surfaces_.shading_normal, at), to_light);
    // An interpolated normal may not let light through the surface.
    const auto is_lit = hn::And(hn::Gt(cosine_light, zero),
                                hn::And(hn::Gt(cosine, zero), hn::Gt(dot(normal, to_light), zero)));
    const V area = hn::Load(d, e_.area + at), chance = hn::Load(d, e_.chance + at);
    const V whole = hn::Div(hn::Mul(hn::Mul(cosine, cosine_light), area), distance2);
    const V weight = hn::Div(one, hn::Mul(hn::Set(d, e_.samples), chance));
    const V strength = hn::Mul(hn::Mul(hn::Set(d, kInvPi), whole), weight);
    hn::Store(hn::IfThenElseZero(is_lit, strength), d, e_.strength + at);
    const V pdf = hn::Div(hn::Mul(hn::Div(chance, area), distance2), cosine_light);
    hn::Store(pdf, d, e_.pdf + at);
    // The ray ends at a point moved off the emitter as its start is moved off the surface, so that
    // it cannot reach the emitter itself; the direction rounds once per component.
    const V off = hn::Add(on.offset, hn::Mul(hn::Set(d, gamma_of(2)), distance));
    const V3 start = point + normal * hn::Load(d, surfaces_.offset + at);
    store3(d, on.point + emitter_normal * off - start, e_.direction, at);
    store3(d, start, e_.start, at);
    store3(d, to_light, e_.to_light, at);
    hn::Store(u, d, e_.u + at);
    hn::Store(v, d, e_.v + at);
  }

  const LitSurfaces& surfaces_;
  EmitterSamples& e_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
