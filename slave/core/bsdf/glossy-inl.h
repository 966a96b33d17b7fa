// SPDX-License-Identifier: Apache-2.0
// The glossy BSDF, a surface to a lane: a rough dielectric or metal, seen from one direction, glTF 2.0's
// metallic-roughness (appendix B) with all energy kept. Three parts:
//   - GGX facets that reflect once (Walter et al., "Microfacet models for refraction through rough
//     surfaces", 2007) with height-correlated Smith shadowing (Heitz, "Understanding the
//     masking-shadowing function", JCGT 3(2), 2014) and Schlick's Fresnel term;
//   - light that they reflect more than once: what the first part misses of a white surface, spread
//     so that the sum is reciprocal (Kulla and Conty, "Revisiting physically based shading at
//     Imageworks", 2017), coloured by the Fresnel terms that it meets (Fdez-Aguera, "A
//     multiple-scattering microfacet model for real-time image based lighting", JCGT 8(1), 2019);
//   - a diffuse base of what both leave, in and out, in the same form.
// Between dielectric and metal it is so much of the one and so much of the other. A white metal and a
// white dielectric reflect everything, whatever angle and roughness, but for the table's error
// (albedo_table.h; bsdf_test.cpp: below 1 %).
//
// Threads. Pure functions.
#include "slave/core/bsdf/bsdf_layout.h"

#if defined(TESSERA_CORE_GLOSSY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_GLOSSY_INL_H_
#undef TESSERA_CORE_GLOSSY_INL_H_
#else
#define TESSERA_CORE_GLOSSY_INL_H_
#endif

#include "slave/core/bsdf/microfacet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Facets that look alike from all sides. What is asked of them is asked of others, too, that a surface of
// more lobes may have (layered-inl.h).
class EvenFacets {
  using D = ShadeTag;
  using V = hn::Vec<D>;
  using V3 = Vec3<D>;

 public:
  HWY_INLINE EvenFacets(const BsdfPoints& p, size_t at)
      : roughness_(hn::Load(D(), p.roughness + at)), alpha_(alpha_of(roughness_)) {}

  HWY_INLINE V distribution(V3 half) const { return ggx_distribution(half, alpha_); }
  HWY_INLINE V root(V3 w) const { return smith_root(w.z, alpha_); }
  HWY_INLINE V3 visible(V3 viewer, V x, V y) const { return visible_normal(viewer, alpha_, x, y); }
  // Of facets that look alike from all sides and hide as much of this direction, or of all.
  HWY_INLINE V roughness(V3) const { return roughness_; }
  HWY_INLINE V roughness() const { return roughness_; }

  // Reflectance at grazing incidence, of all and of what is no metal, and products with it.
  HWY_INLINE V at_grazing() const { return hn::Set(D(), 1); }
  HWY_INLINE V dielectric_at_grazing() const { return hn::Set(D(), 1); }
  HWY_INLINE V times_at_grazing(V x) const { return x; }
  HWY_INLINE V times_dielectric_at_grazing(V x) const { return x; }

 private:
  V roughness_, alpha_;
};

template <class Facets>
class GlossyLobes {
  using D = ShadeTag;
  using V = hn::Vec<D>;
  using V3 = Vec3<D>;

 public:
  struct Value {
    V3 times_pi;
    V pdf;  // by solid angle
  };
  struct Sample {
    V3 direction;  // unit
    V3 weight;     // BSDF times cosine over pdf; zero: nothing comes from there
    V pdf;
  };

  // Surfaces `at` and on, in a frame about their normals.
  HWY_INLINE GlossyLobes(const AlbedoView& view, const BsdfPoints& p, size_t at,
                         const Facets& facets_of, const Basis<D>& basis)
      : table_(view),
        facets_(facets_of),
        normal_(load3(D(), p.normal, at)),
        basis_(basis),
        viewer_(local(load3(D(), p.to_viewer, at))) {
    const D d;
    const V metalness = hn::Load(d, p.metalness + at), zero = hn::Zero(d);
    const V of_rest = hn::Sub(hn::Set(d, 1), metalness);
    const V3 albedo = load3(d, p.albedo, at), specular = load3(d, p.specular, at);
    f0_ = specular * of_rest + albedo * metalness;
    const SpecularAlbedo here = table_.at(viewer_.z, facets_.roughness(viewer_));
    const SpecularAlbedo all = table_.mean(facets_.roughness());
    const V3 of_dielectric = several_albedo(specular, facets_.dielectric_at_grazing(), all);
    const V3 of_metal = several_albedo(albedo, hn::Set(d, 1), all);
    const V3 several_albedo =
        of_dielectric * of_rest +
        if_then_else(hn::Gt(metalness, zero), of_metal, grey(zero)) * metalness;
    several_ = ratio(several_albedo * missing(here), grey(missing(all)));
    dielectric_ = {specular, of_dielectric};
    const V3 body = albedo * of_rest, passed = left_of(here, dielectric_);
    base_ = body * ratio(passed, left_of(all, dielectric_));
    const V facets = hn::Add(hn::Mul(mean(f0_), here.scale), facets_.times_at_grazing(here.bias));
    const V even = hn::Add(hn::Mul(mean(several_albedo), missing(here)), mean(body * passed));
    whole_ = hn::Add(facets, even);
    facets_share_ = hn::IfThenElse(hn::Gt(whole_, zero), hn::Div(facets, whole_), hn::Set(d, 1));
  }

  // About what part of an even light comes to the viewer.
  HWY_INLINE V whole() const { return whole_; }
  // The direction to the viewer in the frame.
  HWY_INLINE V3 viewer() const { return viewer_; }
  HWY_INLINE V viewer_z() const { return viewer_.z; }

  HWY_INLINE Value evaluate(V3 to_light) const { return evaluate_local(local(to_light)); }

  // x, y: in the unit square.
  HWY_INLINE Sample sample(V x, V y) const {
    const D d;
    const V zero = hn::Zero(d);
    const V3 light = sample_local(x, y);
    const Value value = evaluate_local(light);
    const auto is_there = hn::Gt(value.pdf, zero);
    const V3 weight = value.times_pi * hn::Div(hn::Mul(hn::Set(d, kInvPi), light.z), value.pdf);
    return {normalize(world(light)), if_then_else(is_there, weight, grey(zero)),
            hn::IfThenElseZero(is_there, value.pdf)};
  }

  // A direction to the light, in the frame of the shading normal.
  HWY_INLINE V3 sample_local(V x, V y) const {
    const D d;
    const V one = hn::Set(d, 1), zero = hn::Zero(d), below_one = hn::Set(d, 1 - kRoundoff);
    const auto is_facet = hn::Lt(x, facets_share_);
    const V over_share = hn::Div(x, facets_share_);
    const V over_rest = hn::Div(hn::Sub(x, facets_share_), hn::Sub(one, facets_share_));
    const V3 half = facets_.visible(viewer_, hn::Min(over_share, below_one), y);
    const V3 mirrored = normalize(half * hn::Mul(hn::Set(d, 2), dot(viewer_, half)) - viewer_);
    const V3 even = cosine_direction(d, V3{zero, zero, one}, hn::Min(over_rest, below_one), y);
    return if_then_else(is_facet, mirrored, even);
  }

  HWY_INLINE V3 world(V3 in_frame) const {
    return basis_.tangent * in_frame.x + basis_.bitangent * in_frame.y + normal_ * in_frame.z;
  }
  HWY_INLINE V3 local(V3 in_world) const {
    return {dot(basis_.tangent, in_world), dot(basis_.bitangent, in_world), dot(normal_, in_world)};
  }

  HWY_INLINE Value evaluate_local(V3 light) const {
    const D d;
    const V zero = hn::Zero(d), two = hn::Set(d, 2), inv_pi = hn::Set(d, kInvPi);
    const V3 half = normalize(light + viewer_);
    const V3 fresnel = f0_ + (grey(facets_.at_grazing()) - f0_) * schlick_rise(dot(viewer_, half));
    const V distribution = facets_.distribution(half);
    const V root_viewer = facets_.root(viewer_), root_light = facets_.root(light);
    const V shadowed = hn::Add(hn::Mul(root_viewer, light.z), hn::Mul(root_light, viewer_.z));
    const V facets = hn::Div(distribution, hn::Mul(hn::Set(d, 2 * kInvPi), shadowed));
    const SpecularAlbedo there = table_.at(light.z, facets_.roughness(light));
    const V3 times_pi =
        fresnel * facets + several_ * missing(there) + base_ * left_of(there, dielectric_);
    const V of_facets = hn::Div(hn::Mul(facets_share_, distribution),
                                hn::Mul(two, hn::Add(viewer_.z, root_viewer)));
    const V of_rest = hn::Mul(hn::Mul(hn::Sub(hn::Set(d, 1), facets_share_), inv_pi), light.z);
    const auto is_above = hn::And(hn::Gt(light.z, zero), hn::Gt(viewer_.z, zero));
    return {if_then_else(is_above, times_pi, grey(zero)),
            hn::IfThenElseZero(is_above, hn::Add(of_facets, of_rest))};
  }

 private:
  struct Reflecting {
    V3 f0;              // at normal incidence
    V3 several_albedo;  // of light that stays among the facets for a while
  };

  static constexpr float kSmall = 16 * kRoundoff / (1 - 16 * kRoundoff);  // gamma(16)

  static HWY_INLINE V3 grey(V x) { return {x, x, x}; }
  static HWY_INLINE V mean(V3 c) {
    return hn::Mul(hn::Add(hn::Add(c.x, c.y), c.z), hn::Set(D(), 1 / 3.0f));
  }
  // a / b by channel, 0 where b is none to speak of: the facets take all, and a is none either.
  static HWY_INLINE V3 ratio(V3 a, V3 b) {
    const V small = hn::Set(D(), kSmall);
    return {hn::IfThenElseZero(hn::Gt(b.x, small), hn::Div(a.x, b.x)),
            hn::IfThenElseZero(hn::Gt(b.y, small), hn::Div(a.y, b.y)),
            hn::IfThenElseZero(hn::Gt(b.z, small), hn::Div(a.z, b.z))};
  }
  static HWY_INLINE V missing(SpecularAlbedo a) {
    const D d;
    return hn::Max(hn::Zero(d), hn::Sub(hn::Set(d, 1), hn::Add(a.scale, a.bias)));
  }

  // Of light that a first bounce keeps among the facets, what comes out in the end. The mean of
  // Schlick's term over all directions is f0 + (1 - f0) / 21, and light meets it again and again.
  static HWY_INLINE V3 several_albedo(V3 f0, V at_grazing, SpecularAlbedo all) {
    const D d;
    const V one = hn::Set(d, 1), lost = missing(all);
    const V3 fresnel = f0 + (grey(at_grazing) - f0) * hn::Set(d, 1 / 21.0f);
    return ratio(fresnel * fresnel * hn::Sub(one, lost), grey(one) - fresnel * lost);
  }

  // What facets leave for the base, once for the way in and once for the way out; not below 0 by
  // rounding.
  HWY_INLINE V3 left_of(SpecularAlbedo a, const Reflecting& f) const {
    const D d;
    const V zero = hn::Zero(d), bias = facets_.times_dielectric_at_grazing(a.bias);
    const V3 left =
        grey(hn::Set(d, 1)) - (f.f0 * a.scale + grey(bias) + f.several_albedo * missing(a));
    return {hn::Max(left.x, zero), hn::Max(left.y, zero), hn::Max(left.z, zero)};
  }

  AlbedoLookup table_;
  Facets facets_;
  V3 normal_;
  Basis<D> basis_;
  V3 viewer_;  // local
  V3 f0_;
  V3 several_;  // of light met more than once: times what a direction misses
  Reflecting dielectric_;
  V3 base_;  // of the diffuse part: times what the facets leave of a direction
  V whole_;
  V facets_share_;  // of samples
};

HWY_INLINE GlossyLobes<EvenFacets> plain_lobes(const AlbedoView& table, const BsdfPoints& p,
                                               size_t at) {
  const ShadeTag d;
  return {table, p, at, EvenFacets(p, at), basis_about(d, load3(d, p.normal, at))};
}

// To points.value and points.pdf.
inline void evaluate_glossy(const AlbedoView& table, BsdfPoints& p) {
  const ShadeTag d;
  for (int i = 0; i < p.count; i += static_cast<int>(hn::Lanes(d))) {
    const auto at = static_cast<size_t>(i);
    const auto v = plain_lobes(table, p, at).evaluate(load3(d, p.direction, at));
    store3(d, v.times_pi, p.value, at);
    hn::Store(v.pdf, d, p.pdf + at);
  }
}

// To points.direction, value and pdf.
inline void sample_glossy(const AlbedoView& table, BsdfPoints& p) {
  const ShadeTag d;
  for (int i = 0; i < p.count; i += static_cast<int>(hn::Lanes(d))) {
    const auto at = static_cast<size_t>(i);
    const auto s = plain_lobes(table, p, at)
                       .sample(hn::Load(d, p.square[0] + at), hn::Load(d, p.square[1] + at));
    store3(d, s.direction, p.direction, at);
    store3(d, s.weight, p.value, at);
    hn::Store(s.pdf, d, p.pdf + at);
  }
}

// To points.direction and pdf.
inline void sample_diffuse(BsdfPoints& p) {
  const ShadeTag d;
  for (int i = 0; i < p.count; i += static_cast<int>(hn::Lanes(d))) {
    const auto at = static_cast<size_t>(i);
    const auto normal = load3(d, p.normal, at);
    const auto direction =
        cosine_direction(d, normal, hn::Load(d, p.square[0] + at), hn::Load(d, p.square[1] + at));
    store3(d, direction, p.direction, at);
    hn::Store(hn::Mul(dot(direction, normal), hn::Set(d, kInvPi)), d, p.pdf + at);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
