// SPDX-License-Identifier: Apache-2.0
// The glossy BSDF with all its optional lobes, one surface per lane (Khronos' extensions of glTF
// 2.0 of the same names). Its layers, from the outside inwards:
//   - varnish (clearcoat): GGX facets of a dielectric, ior 1.5, about a normal of its own;
//   - sheen: fibres that stand up (Estevez and Kulla, "Production friendly microfacet sheen BRDF",
//     2017) with the shadowing of cloth (Neubelt and Pettineo, "Crafting a next-gen material
//     pipeline for The Order: 1886", 2013);
//   - the glossy surface (glossy-inl.h), whose facets may be longer along one direction (Heitz
//     2014, section 5.4), with its own reflectance at grazing incidence.
// Sheen passes to what lies below it 1 minus its albedo, seen from the viewer or from the light,
// whichever is less. That is reciprocal, and a white surface below sends out no more than came in.
// What comes out everywhere (multiple scattering and the diffuse base) varnish passes on the way in
// and on the way out, T(o) T(i) with T = 1 - albedo, over the mean share that passes both, since
// what it keeps below comes back to it (C. Kelemen and L. Szirmay-Kalos, "A microfacet based
// coupled specular-matte BRDF model", Eurographics 2001): a white surface then sends out what came
// in.
// Facets that reflect once get the lesser of T(o) and T(i), which a mirror keeps whole, and lose
// L(o) beside 1 - T(o) of what they reflect. That is put back as L(o) L(i) over its mean, so that
// white facets, too, send out what came in, whatever both roughnesses are (bsdf/coat_table.h).
//
// Stretched facets shadow a grazing direction as much as isotropic ones of the width along it do
// (Heitz 2014), so that the table of isotropic facets serves both. From grazing directions to the
// normal, alpha squared changes with the square of the cosine to the product of both widths.
// Multiple scattering takes the mean over all directions.
//
// Threads. Pure functions.
#include "slave/core/bsdf/lobes_layout.h"

#if defined(TESSERA_CORE_LAYERED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_LAYERED_INL_H_
#undef TESSERA_CORE_LAYERED_INL_H_
#else
#define TESSERA_CORE_LAYERED_INL_H_
#endif

#include "slave/core/bsdf/coat-inl.h"
#include "slave/core/bsdf/glossy-inl.h"
#include "slave/core/bsdf/sheen-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Albedos of facets by the finer table where varnish lies on them. Elsewhere the bits are those of
// surfaces that never have it.
class FacetsUnderCoat {
  using V = Floats;

 public:
  HWY_INLINE FacetsUnderCoat(const LobeTables& tables, const LobePoints& q, size_t at)
      : usual_(tables.facets), fine_(tables.coat.facets), coat_(load<V>(q.coat + at)) {}

  HWY_INLINE AlbedoTerms<V> at(V cosine, V roughness) const {
    return chosen(fine_.at(cosine, roughness), usual_.at(cosine, roughness));
  }
  HWY_INLINE AlbedoTerms<V> mean(V roughness) const {
    return chosen(fine_.mean(roughness), usual_.mean(roughness));
  }

 private:
  HWY_INLINE AlbedoTerms<V> chosen(AlbedoTerms<V> fine, AlbedoTerms<V> usual) const {
    const auto is_coated = coat_ > 0;
    return {select(is_coated, fine.scale, usual.scale), select(is_coated, fine.bias, usual.bias)};
  }

  AlbedoLookup<V> usual_, fine_;
  V coat_;
};

// Facets that are wider along x of the frame, and reflectances at grazing incidence.
class StretchedFacets {
  using V = Floats;
  using V3 = Vec3<V>;

 public:
  using Albedo = FacetsUnderCoat;

  HWY_INLINE StretchedFacets(const BsdfPoints& p, const LobePoints& q, size_t at) {
    const V metalness = load<V>(p.metalness + at);
    dielectric_ = load<V>(q.specular_f90 + at);
    at_grazing_ = dielectric_ * (1 - metalness) + metalness;
    const V stretch = load<V>(q.stretch + at);
    across_ = alpha_of(load<V>(p.roughness + at));
    along_ = across_ + stretch * stretch * (1 - across_);
    upright2_ = along_ * across_;
    const V squares = along_ * along_ + across_ * across_;
    const V mean2 = (squares * 0.5f + upright2_) * 0.5f;
    mean_ = sqrt(sqrt(mean2));
  }

  HWY_INLINE V distribution(V3 half) const {
    const V x = half.x / along_, y = half.y / across_;
    const V norm = x * x + y * y + half.z * half.z;
    return kInvPi / (along_ * across_ * norm * norm);
  }
  HWY_INLINE V root(V3 w) const {
    const V x = w.x * along_, y = w.y * across_;
    return sqrt(w.z * w.z + (x * x + y * y));
  }
  HWY_INLINE V3 visible(V3 viewer, V x, V y) const {
    return visible_normal(viewer, along_, across_, x, y);
  }
  HWY_INLINE V roughness(V3 w) const {
    const V x = w.x * along_, y = w.y * across_;
    const V alpha2 = x * x + y * y + upright2_ * (w.z * w.z);
    return sqrt(sqrt(alpha2));
  }
  HWY_INLINE V roughness() const { return mean_; }
  HWY_INLINE V at_grazing() const { return at_grazing_; }
  HWY_INLINE V dielectric_at_grazing() const { return dielectric_; }
  HWY_INLINE V times_at_grazing(V x) const { return x * at_grazing_; }
  HWY_INLINE V times_dielectric_at_grazing(V x) const { return x * dielectric_; }

 private:
  V along_, across_;  // widths alpha
  V upright2_;        // alpha squared that serves for the direction of the normal
  V mean_;            // roughness
  V at_grazing_, dielectric_;
};

class LayeredLobes {
  using V = Floats;
  using V3 = Vec3<V>;
  using Base = GlossyLobes<StretchedFacets>;

 public:
  using Value = Base::Value;
  using Sample = Base::Sample;

  HWY_INLINE LayeredLobes(const LobeTables& tables, const BsdfPoints& p, const LobePoints* lobes,
                          size_t at)
      : LayeredLobes(tables, p, *lobes, at) {}
  HWY_INLINE LayeredLobes(const LobeTables& tables, const BsdfPoints& p, const LobePoints& q,
                          size_t at)
      : coat_albedo_(tables.coat.facets),
        sheen_table_(tables.sheen),
        base_(FacetsUnderCoat(tables, q, at), p, at, StretchedFacets(p, q, at), frame_of(p, q, at)),
        coat_normal_(load3<V>(q.coat_normal, at)),
        coat_basis_(basis_about(coat_normal_)),
        coat_viewer_(in_coat(load3<V>(p.to_viewer, at))),
        coat_table_(tables.coat, base_.roughness(), load<V>(q.coat_roughness + at)),
        sheen_(load3<V>(q.sheen, at)) {
    coat_ = load<V>(q.coat + at);
    coat_roughness_ = load<V>(q.coat_roughness + at);
    coat_alpha_ = alpha_of(coat_roughness_);
    sheen_roughness_ = max(load<V>(q.sheen_roughness + at), kSheenRoughnessMin);
    sheen_power_ = 1 / (sheen_roughness_ * sheen_roughness_);
    coat_to_viewer_ = coat_albedo(coat_viewer_.z);
    couple();
    fibres_to_viewer_ = fibres_albedo(base_.viewer_z());
    sheen_to_viewer_ = largest(sheen_) * min(fibres_to_viewer_, 1);
    const V below_coat = 1 - coat_to_viewer_;
    const V sheen =
        (sheen_.x + sheen_.y + sheen_.z) * (1 / 3.0f) * (min(fibres_to_viewer_, 1) * below_coat);
    const V rest = base_.whole() * (1 - sheen_to_viewer_) * below_coat;
    // What the coat keeps of facets and gives back comes from everywhere, as sheen does.
    const V back = (back_to_viewer_.x + back_to_viewer_.y + back_to_viewer_.z) * (1 / 3.0f);
    const V even = sheen + back;
    const V whole = coat_to_viewer_ + even + rest;
    const auto is_any = whole > 0;
    coat_share_ = zero_unless(is_any, coat_to_viewer_ / whole);
    even_share_ = zero_unless(is_any, even / whole);
  }

  HWY_INLINE Value evaluate(V3 to_light) const {
    const V3 light = base_.local(to_light), coat_light = in_coat(to_light);
    const auto base = base_.parts_of(light);
    const Value coat = evaluate_coat(coat_light);
    const V coat_to_light = coat_albedo(coat_light.z);
    const V below_coat = 1 - max(coat_to_viewer_, coat_to_light);
    const V both = (1 - coat_to_viewer_) * (1 - coat_to_light);
    const V3 coated = base.facets * below_coat + base.several * (several_coupling_ * both) +
                      base.body * body_coupling_ * both + regained_ * lost(coat_light.z);
    const V fibres_to_light = fibres_albedo(light.z);
    const V sheen_to_light = largest(sheen_) * min(fibres_to_light, 1);
    const V below_sheen = 1 - max(sheen_to_viewer_, sheen_to_light);
    // Fibres that would reflect more light than comes are dimmed until they do not.
    const V most = max(set<V>(1), max(fibres_to_viewer_, fibres_to_light));
    // Turns the cosine to the coat's normal into that to the surface's normal, by which the value
    // will be multiplied.
    const V3 of_coat = coat.times_pi * (coat_light.z / light.z);
    const V3 all =
        of_coat + coated * below_sheen + sheen_ * (sheen_times_pi(light) / most * below_coat);
    const V base_share = 1 - coat_share_ - even_share_;
    const V even = kInvPi * light.z;
    const V pdf = coat_share_ * coat.pdf + (even_share_ * even + base_share * base.pdf);
    const auto is_above = light.z > 0 && base_.viewer_z() > 0;
    return {zero_unless(is_above, all), zero_unless(is_above, pdf)};
  }

  HWY_INLINE Sample sample(V x, V y) const {
    constexpr float kBelowOne = 1 - kRoundoff;
    const V layers = coat_share_ + even_share_;
    const auto is_coat = x < coat_share_, is_base = x >= layers;
    const auto within = [&](V from, V share) { return min(max((x - from) / share, 0), kBelowOne); };
    const V3 half = visible_normal(coat_viewer_, coat_alpha_, within(set<V>(0), coat_share_), y);
    const V3 mirrored = half * (2 * dot(coat_viewer_, half)) - coat_viewer_;
    const V3 even = cosine_direction(Base::upright(), within(coat_share_, even_share_), y);
    const V3 of_base = base_.sample_local(within(layers, 1 - layers), y);
    const V3 direction = normalize(
        select(is_coat, from_coat(mirrored), base_.world(select(is_base, of_base, even))));
    const Value value = evaluate(direction);
    const auto is_there = value.pdf > 0;
    const V cosine = base_.local(direction).z;
    const V3 weight = value.times_pi * (kInvPi * cosine / value.pdf);
    return {direction, zero_unless(is_there, weight), zero_unless(is_there, value.pdf)};
  }

 private:
  // A frame about the shading normal, with x along the tangent where the facets are stretched.
  static HWY_INLINE Basis<V> frame_of(const BsdfPoints& p, const LobePoints& q, size_t at) {
    const V3 normal = load3<V>(p.normal, at), tangent = load3<V>(q.tangent, at);
    const auto is_stretched = load<V>(q.stretch + at) > 0;
    const Basis<V> any = basis_about(normal);
    return {select(is_stretched, tangent, any.tangent),
            select(is_stretched, cross(normal, tangent), any.bitangent)};
  }

  // Finds what depends on all directions to the light.
  HWY_INLINE void couple() {
    const auto kept = coat_table_.means();
    const V3 left = base_.mean_left();
    const V3 kept_of_left =
        base_.left_of_share(kept.albedo, {kept.of_scale, kept.of_bias}, kept.of_missing);
    several_coupling_ = 1 / (1 - coat_ * kept.share_of_missing);
    body_coupling_ = {over_passed(left.x, kept_of_left.x), over_passed(left.y, kept_of_left.y),
                      over_passed(left.z, kept_of_left.z)};
    const V3 all = base_.reflected(kept.regained) * coat_;
    back_to_viewer_ = lost(coat_viewer_.z);
    const auto over = [](V x, V mean) { return zero_unless(mean > 0, x / mean); };
    regained_ = {over(back_to_viewer_.x, all.x), over(back_to_viewer_.y, all.y),
                 over(back_to_viewer_.z, all.z)};
  }

  // What facets lose to the coat of the light from a direction.
  HWY_INLINE V3 lost(V cosine) const {
    return base_.reflected(coat_table_.regained(cosine)) * coat_;
  }
  // whole / (whole - what a coat keeps of it); 1 where the whole counts for nothing.
  HWY_INLINE V over_passed(V whole, V kept) const {
    constexpr float kSmall = 1e-3f;
    const V passed = whole - coat_ * min(max(kept, 0), 0.5f * whole);
    return select(whole > kSmall, whole / passed, set<V>(1));
  }

  HWY_INLINE V3 in_coat(V3 world) const {
    return {dot(coat_basis_.tangent, world), dot(coat_basis_.bitangent, world),
            dot(coat_normal_, world)};
  }
  HWY_INLINE V3 from_coat(V3 v) const {
    return coat_basis_.tangent * v.x + coat_basis_.bitangent * v.y + coat_normal_ * v.z;
  }

  // The share of light from a direction that the coat reflects.
  HWY_INLINE V coat_albedo(V cosine) const {
    const AlbedoTerms<V> a = coat_albedo_.at(max(cosine, 0), coat_roughness_);
    return coat_ * (kCoatF0 * a.scale + a.bias);
  }
  // The albedo of white fibres; it may be above 1.
  HWY_INLINE V fibres_albedo(V cosine) const {
    return sheen_table_.at(max(cosine, 0), sheen_roughness_).scale;
  }

  HWY_INLINE Value evaluate_coat(V3 light) const {
    const V3 half = normalize(light + coat_viewer_);
    const V rise = schlick_rise(dot(coat_viewer_, half));
    const V fresnel = coat_ * (kCoatF0 + (1 - kCoatF0) * rise);
    const V distribution = ggx_distribution(half, coat_alpha_);
    const V root_viewer = smith_root(coat_viewer_.z, coat_alpha_);
    const V root_light = smith_root(light.z, coat_alpha_);
    const V shadowed = root_viewer * light.z + root_light * coat_viewer_.z;
    const V facets = distribution / (2 * kInvPi * shadowed);
    const auto is_above = light.z > 0 && coat_viewer_.z > 0;
    const V value = zero_unless(is_above, fresnel * facets);
    const V pdf = distribution / (2 * (coat_viewer_.z + root_viewer));
    return {{value, value, value}, zero_unless(is_above, pdf)};
  }

  // The value of white sheen, times pi.
  HWY_INLINE V sheen_times_pi(V3 light) const {
    const V v = base_.viewer_z();
    const V3 half = normalize(light + base_.viewer());
    const V value = fibres_times_pi(sheen_power_, half.z, v, light.z);
    return zero_unless(light.z > 0 && v > 0, value);
  }

  AlbedoLookup<V> coat_albedo_, sheen_table_;
  Base base_;
  V3 coat_normal_;
  Basis<V> coat_basis_;
  V3 coat_viewer_;  // in the coat's frame
  CoatLookup<V> coat_table_;
  V3 sheen_;
  V coat_, coat_roughness_, coat_alpha_;
  V sheen_roughness_, sheen_power_;
  V coat_to_viewer_, sheen_to_viewer_;  // albedos towards the viewer
  V fibres_to_viewer_;                  // likewise, of white fibres; may be above 1
  V coat_share_, even_share_;           // shares of samples; the latter's come from everywhere
  // 1 over the mean share of what comes out everywhere that the coat passes.
  V several_coupling_;
  V3 body_coupling_;
  V3 back_to_viewer_;  // what facets lose to the coat of the light from the viewer
  V3 regained_;        // what facets lose to the coat: to be multiplied by what a direction loses
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
