// SPDX-License-Identifier: Apache-2.0
// A rough diffuse BSDF, one surface for each lane. Its facets are Lambertian (Oren and Nayar,
// "Generalization of Lambert's reflectance model", 1994). Its form is that of Fujii, "A tiny
// improvement of Oren-Nayar reflectance model", whose terms are continuous and reciprocal.
//
// Threads. Pure functions.
#include "slave/core/bsdf/lobes_layout.h"

#if defined(TESSERA_TEST_ROUGH_DIFFUSE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_TEST_ROUGH_DIFFUSE_INL_H_
#undef TESSERA_TEST_ROUGH_DIFFUSE_INL_H_
#else
#define TESSERA_TEST_ROUGH_DIFFUSE_INL_H_
#endif

#include "slave/core/bsdf/microfacet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

class RoughDiffuse {
  using V = Floats;
  using V3 = Vec3<V>;

 public:
  struct Value {
    V3 times_pi;
    V pdf;
  };
  struct Sample {
    V3 direction, weight;
    V pdf;
  };

  HWY_INLINE RoughDiffuse(const LobeTables&, const BsdfPoints& p, const LobePoints*, size_t at)
      : normal_(load3<V>(p.normal, at)),
        viewer_(load3<V>(p.to_viewer, at)),
        albedo_(load3<V>(p.albedo, at)),
        roughness_(load<V>(p.roughness + at)) {}

  HWY_INLINE Value evaluate(V3 to_light) const {
    const V light_z = dot(normal_, to_light), viewer_z = dot(normal_, viewer_);
    const V along = dot(to_light, viewer_) - light_z * viewer_z;
    const V over = select(along > 0, max(light_z, viewer_z), set<V>(1));
    const V even = 1 / (1 + roughness_ * (0.5f - 2 * kInvPi / 3));
    const V3 times_pi = albedo_ * (even * (1 + roughness_ * (along / over)));
    const auto is_above = light_z > 0 && viewer_z > 0;
    return {zero_unless(is_above, times_pi), zero_unless(is_above, kInvPi * light_z)};
  }

  HWY_INLINE Sample sample(V x, V y) const {
    const V3 direction = cosine_direction(normal_, x, y);
    const Value value = evaluate(direction);
    return {direction, value.times_pi, value.pdf};
  }

 private:
  V3 normal_, viewer_, albedo_;
  V roughness_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
