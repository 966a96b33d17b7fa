// SPDX-License-Identifier: Apache-2.0
// The glossy BSDF, one surface per lane, seen from one direction: a rough dielectric or metal after
// glTF 2.0's metallic-roughness (appendix B), with all energy kept. It has three parts:
//   - GGX facets that reflect once (Walter et al., "Microfacet models for refraction through rough
//     surfaces", 2007) with height-correlated Smith shadowing (Heitz, "Understanding the
//     masking-shadowing function", JCGT 3(2), 2014) and Schlick's Fresnel term;
//   - multiple scattering between the facets: what the first part misses of a white surface, spread
//     so that the sum is reciprocal (Kulla and Conty, "Revisiting physically based shading at
//     Imageworks", 2017), coloured by the Fresnel terms that it meets (Fdez-Aguera, "A
//     multiple-scattering microfacet model for real-time image based lighting", JCGT 8(1), 2019);
//   - a diffuse base, which gets what both leave on the way in and out, in the same form.
// A metalness between 0 and 1 mixes dielectric and metal linearly. A white metal and a white
// dielectric reflect everything, whatever angle and roughness, but for the table's error
// (albedo_table.h; bsdf_test.cpp: below 1 %).
//
// Threads. Pure functions.
#include "slave/core/bsdf/lobes_layout.h"

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

// Isotropic facets. StretchedFacets (layered-inl.h) has the same interface.
class EvenFacets {
  using V = Floats;
  using V3 = Vec3<V>;

 public:
  using Albedo = AlbedoLookup<V>;  // of facets

  HWY_INLINE EvenFacets(const BsdfPoints& p, size_t at)
      : roughness_(load<V>(p.roughness + at)), alpha_(alpha_of(roughness_)) {}

  HWY_INLINE V distribution(V3 half) const { return ggx_distribution(half, alpha_); }
  HWY_INLINE V root(V3 w) const { return smith_root(w.z, alpha_); }
  HWY_INLINE V3 visible(V3 viewer, V x, V y) const { return visible_normal(viewer, alpha_, x, y); }
  // Roughness of isotropic facets that shadow this direction as much as these facets do; without a
  // direction, the mean over all.
  HWY_INLINE V roughness(V3) const { return roughness_; }
  HWY_INLINE V roughness() const { return roughness_; }

  // Reflectance at grazing incidence of the whole surface and of its dielectric part, and products
  // with each.
  HWY_INLINE V at_grazing() const { return set<V>(1); }
  HWY_INLINE V dielectric_at_grazing() const { return set<V>(1); }
  HWY_INLINE V times_at_grazing(V x) const { return x; }
  HWY_INLINE V times_dielectric_at_grazing(V x) const { return x; }

 private:
  V roughness_, alpha_;
};

template <class Facets>
class GlossyLobes {
  using V = Floats;
  using V3 = Vec3<V>;

 public:
  struct Value {
    V3 times_pi;
    V pdf;  // by solid angle
  };
  // What the value is the sum of: facets that reflect once, multiple scattering, diffuse base.
  struct Parts {
    V3 facets, several, body;  // times pi; only where both directions are above
    V pdf;
  };
  struct Sample {
    V3 direction;  // unit
    V3 weight;     // BSDF times cosine over pdf; zero: nothing comes from there
    V pdf;
  };

  // Takes the surfaces from `at` on, in a frame about their normals.
  HWY_INLINE GlossyLobes(const typename Facets::Albedo& table, const BsdfPoints& p, size_t at,
                         const Facets& facets_of, const Basis<V>& basis)
      : table_(table),
        facets_(facets_of),
        normal_(load3<V>(p.normal, at)),
        basis_(basis),
        viewer_(local(load3<V>(p.to_viewer, at))) {
    const V metalness = load<V>(p.metalness + at), of_rest = 1 - metalness;
    const V3 albedo = load3<V>(p.albedo, at), specular = load3<V>(p.specular, at);
    f0_ = specular * of_rest + albedo * metalness;
    const AlbedoTerms<V> here = table_.at(viewer_.z, facets_.roughness(viewer_));
    const AlbedoTerms<V> all = table_.mean(facets_.roughness());
    const V3 of_dielectric = several_albedo(specular, facets_.dielectric_at_grazing(), all);
    const V3 of_metal = several_albedo(albedo, set<V>(1), all);
    const V3 several_albedo =
        of_dielectric * of_rest + zero_unless(metalness > 0, of_metal) * metalness;
    several_ = ratio(several_albedo * missing(here), grey(missing(all)));
    dielectric_ = {specular, of_dielectric};
    const V3 body = albedo * of_rest, passed = left_of(here, dielectric_);
    base_ = body * ratio(passed, left_of(all, dielectric_));
    const V facets = mean(f0_) * here.scale + facets_.times_at_grazing(here.bias);
    const V even = mean(several_albedo) * missing(here) + mean(body * passed);
    whole_ = facets + even;
    facets_share_ = select(whole_ > 0, facets / whole_, set<V>(1));
  }

  // Returns: about the share of an even light from all sides that is reflected to the viewer.
  HWY_INLINE V whole() const { return whole_; }
  // The direction to the viewer in the frame.
  HWY_INLINE V3 viewer() const { return viewer_; }
  HWY_INLINE V viewer_z() const { return viewer_.z; }

  HWY_INLINE Value evaluate(V3 to_light) const { return evaluate_local(local(to_light)); }

  // x, y: in the unit square.
  HWY_INLINE Sample sample(V x, V y) const {
    const V3 light = sample_local(x, y);
    const Value value = evaluate_local(light);
    const auto is_there = value.pdf > 0;
    const V3 weight = value.times_pi * (kInvPi * light.z / value.pdf);
    return {normalize(world(light)), zero_unless(is_there, weight),
            zero_unless(is_there, value.pdf)};
  }

  // Samples a direction to the light, in the frame of the shading normal.
  HWY_INLINE V3 sample_local(V x, V y) const {
    constexpr float kBelowOne = 1 - kRoundoff;
    const auto is_facet = x < facets_share_;
    const V over_share = x / facets_share_;
    const V over_rest = (x - facets_share_) / (1 - facets_share_);
    const V3 half = facets_.visible(viewer_, min(over_share, kBelowOne), y);
    const V3 mirrored = normalize(half * (2 * dot(viewer_, half)) - viewer_);
    const V3 even = cosine_direction(upright(), min(over_rest, kBelowOne), y);
    return select(is_facet, mirrored, even);
  }

  // The normal in its own frame.
  static HWY_INLINE V3 upright() { return {set<V>(0), set<V>(0), set<V>(1)}; }
  HWY_INLINE V3 world(V3 in_frame) const {
    return basis_.tangent * in_frame.x + basis_.bitangent * in_frame.y + normal_ * in_frame.z;
  }
  HWY_INLINE V3 local(V3 in_world) const {
    return {dot(basis_.tangent, in_world), dot(basis_.bitangent, in_world), dot(normal_, in_world)};
  }

  HWY_INLINE Value evaluate_local(V3 light) const {
    const Parts parts = parts_of(light);
    const V3 times_pi = parts.facets + parts.several + parts.body;
    const auto is_above = light.z > 0 && viewer_.z > 0;
    return {zero_unless(is_above, times_pi), zero_unless(is_above, parts.pdf)};
  }

  HWY_INLINE Parts parts_of(V3 light) const {
    const V3 half = normalize(light + viewer_);
    const V3 fresnel = f0_ + (grey(facets_.at_grazing()) - f0_) * schlick_rise(dot(viewer_, half));
    const V distribution = facets_.distribution(half);
    const V root_viewer = facets_.root(viewer_), root_light = facets_.root(light);
    const V shadowed = root_viewer * light.z + root_light * viewer_.z;
    const V facets = distribution / (2 * kInvPi * shadowed);
    const AlbedoTerms<V> there = table_.at(light.z, facets_.roughness(light));
    const V of_facets = facets_share_ * distribution / (2 * (viewer_.z + root_viewer));
    const V of_rest = (1 - facets_share_) * kInvPi * light.z;
    return {fresnel * facets, several_ * missing(there), base_ * left_of(there, dielectric_),
            of_facets + of_rest};
  }

  // The share of light from all sides that facets leave for the base.
  HWY_INLINE V3 mean_left() const { return left_of(table_.mean(facets_.roughness()), dielectric_); }
  // What is left of a share, of which so much is in the terms of facets and so much is missed.
  HWY_INLINE V3 left_of_share(V share, AlbedoTerms<V> of_facets, V of_missing) const {
    const V bias = facets_.times_dielectric_at_grazing(of_facets.bias);
    return grey(share - bias) - dielectric_.f0 * of_facets.scale -
           dielectric_.several_albedo * of_missing;
  }
  // What facets reflect of a share that has so much in each term.
  HWY_INLINE V3 reflected(AlbedoTerms<V> terms) const {
    return f0_ * terms.scale + grey(facets_.times_at_grazing(terms.bias));
  }
  HWY_INLINE V roughness() const { return facets_.roughness(); }

 private:
  struct Reflecting {
    V3 f0;              // at normal incidence
    V3 several_albedo;  // of multiply scattered light
  };

  static constexpr float kSmall = 16 * kRoundoff / (1 - 16 * kRoundoff);  // gamma(16)

  static HWY_INLINE V3 grey(V x) { return {x, x, x}; }
  static HWY_INLINE V mean(V3 c) { return (c.x + c.y + c.z) * (1 / 3.0f); }
  // a / b by channel; 0 where b is negligible: there the facets reflect all, and a is negligible,
  // too.
  static HWY_INLINE V3 ratio(V3 a, V3 b) {
    return {zero_unless(b.x > kSmall, a.x / b.x), zero_unless(b.y > kSmall, a.y / b.y),
            zero_unless(b.z > kSmall, a.z / b.z)};
  }
  static HWY_INLINE V missing(AlbedoTerms<V> a) { return max(set<V>(0), 1 - (a.scale + a.bias)); }

  // The share of light, kept among the facets by a first bounce, that comes out in the end. The
  // mean of Schlick's term over all directions is f0 + (1 - f0) / 21; each further bounce
  // multiplies by it.
  static HWY_INLINE V3 several_albedo(V3 f0, V at_grazing, AlbedoTerms<V> all) {
    const V lost = missing(all);
    const V3 fresnel = f0 + (grey(at_grazing) - f0) * set<V>(1 / 21.0f);
    return ratio(fresnel * fresnel * (1 - lost), grey(set<V>(1)) - fresnel * lost);
  }

  // What facets leave for the base, once for the way in and once for the way out; not below 0 by
  // rounding.
  HWY_INLINE V3 left_of(AlbedoTerms<V> a, const Reflecting& f) const {
    const V bias = facets_.times_dielectric_at_grazing(a.bias);
    const V3 left = grey(set<V>(1)) - (f.f0 * a.scale + grey(bias) + f.several_albedo * missing(a));
    return {max(left.x, 0), max(left.y, 0), max(left.z, 0)};
  }

  typename Facets::Albedo table_;
  Facets facets_;
  V3 normal_;
  Basis<V> basis_;
  V3 viewer_;  // local
  V3 f0_;
  V3 several_;  // multiple scattering: to be multiplied by what a direction misses
  Reflecting dielectric_;
  V3 base_;  // diffuse base: to be multiplied by what the facets leave of a direction
  V whole_;
  V facets_share_;  // share of samples
};

// The glossy BSDF without optional lobes.
class PlainGlossy : public GlossyLobes<EvenFacets> {
 public:
  HWY_INLINE PlainGlossy(const LobeTables& tables, const BsdfPoints& p, const LobePoints*,
                         size_t at)
      : GlossyLobes(AlbedoLookup<Floats>(tables.facets), p, at, EvenFacets(p, at),
                    basis_about(load3<Floats>(p.normal, at))) {}
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
