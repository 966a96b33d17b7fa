// SPDX-License-Identifier: Apache-2.0
// The glossy BSDF with all its optional lobes, a surface to a lane (Khronos' extensions of glTF 2.0 of the
// same names). From the outside inwards:
//   - varnish (clearcoat): GGX facets of a dielectric, ior 1.5, about a normal of its own;
//   - sheen: fibres that stand up (Estevez and Kulla, "Production friendly microfacet sheen BRDF", 2017)
//     with the shadowing of cloth (Neubelt and Pettineo, "Crafting a next-gen material pipeline for The
//     Order: 1886", 2013);
//   - the glossy surface (glossy-inl.h), whose facets may be longer along one direction (Heitz 2014,
//     section 5.4), with its own reflectance at grazing incidence.
// A layer leaves to what lies below 1 minus its albedo, seen from the viewer or from the light, whichever
// is less: reciprocal, and a white surface below sends out no more than came in.
//
// Of a flat direction facets that are stretched hide as much as even ones of the width along it do (Heitz
// 2014), so that the table of even ones serves both: from there to the normal alpha squared changes with
// the cosine's square to the product of both widths. Light that is met more than once takes the mean.
//
// Threads. Pure functions.
#include "slave/core/bsdf/lobes_layout.h"

#if defined(TESSERA_CORE_LAYERED_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_LAYERED_INL_H_
#undef TESSERA_CORE_LAYERED_INL_H_
#else
#define TESSERA_CORE_LAYERED_INL_H_
#endif

#include "slave/core/bsdf/glossy-inl.h"
#include "slave/core/simd/power-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

// Facets that are wider along x of the frame, and reflectances at grazing incidence.
class StretchedFacets {
  using D = ShadeTag;
  using V = hn::Vec<D>;
  using V3 = Vec3<D>;

 public:
  HWY_INLINE StretchedFacets(const BsdfPoints& p, const LobePoints& q, size_t at) {
    const D d;
    const V one = hn::Set(d, 1), metalness = hn::Load(d, p.metalness + at);
    dielectric_ = hn::Load(d, q.specular_f90 + at);
    at_grazing_ = hn::Add(hn::Mul(dielectric_, hn::Sub(one, metalness)), metalness);
    const V stretch = hn::Load(d, q.stretch + at);
    across_ = alpha_of(hn::Load(d, p.roughness + at));
    along_ = hn::Add(across_, hn::Mul(hn::Mul(stretch, stretch), hn::Sub(one, across_)));
    upright2_ = hn::Mul(along_, across_);
    const V squares = hn::Add(hn::Mul(along_, along_), hn::Mul(across_, across_));
    const V mean2 =
        hn::Mul(hn::Add(hn::Mul(squares, hn::Set(d, 0.5f)), upright2_), hn::Set(d, 0.5f));
    mean_ = hn::Sqrt(hn::Sqrt(mean2));
  }

  HWY_INLINE V distribution(V3 half) const {
    const D d;
    const V x = hn::Div(half.x, along_), y = hn::Div(half.y, across_);
    const V norm = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(half.z, half.z));
    return hn::Div(hn::Set(d, kInvPi), hn::Mul(hn::Mul(hn::Mul(along_, across_), norm), norm));
  }
  HWY_INLINE V root(V3 w) const {
    const V x = hn::Mul(w.x, along_), y = hn::Mul(w.y, across_);
    return hn::Sqrt(hn::Add(hn::Mul(w.z, w.z), hn::Add(hn::Mul(x, x), hn::Mul(y, y))));
  }
  HWY_INLINE V3 visible(V3 viewer, V x, V y) const {
    return visible_normal(viewer, along_, across_, x, y);
  }
  HWY_INLINE V roughness(V3 w) const {
    const V x = hn::Mul(w.x, along_), y = hn::Mul(w.y, across_);
    const V alpha2 =
        hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(upright2_, hn::Mul(w.z, w.z)));
    return hn::Sqrt(hn::Sqrt(alpha2));
  }
  HWY_INLINE V roughness() const { return mean_; }
  HWY_INLINE V at_grazing() const { return at_grazing_; }
  HWY_INLINE V dielectric_at_grazing() const { return dielectric_; }
  HWY_INLINE V times_at_grazing(V x) const { return hn::Mul(x, at_grazing_); }
  HWY_INLINE V times_dielectric_at_grazing(V x) const { return hn::Mul(x, dielectric_); }

 private:
  V along_, across_;  // widths alpha
  V upright2_;        // the square of what serves for the direction of the normal
  V mean_;            // roughness
  V at_grazing_, dielectric_;
};

class LayeredLobes {
  using D = ShadeTag;
  using V = hn::Vec<D>;
  using V3 = Vec3<D>;
  using Base = GlossyLobes<StretchedFacets>;

 public:
  using Value = Base::Value;
  using Sample = Base::Sample;

  HWY_INLINE LayeredLobes(const LobeTables& tables, const BsdfPoints& p, const LobePoints& q,
                          size_t at)
      : facets_table_(tables.facets),
        sheen_table_(tables.sheen),
        base_(tables.facets, p, at, StretchedFacets(p, q, at), frame_of(p, q, at)),
        coat_normal_(load3(D(), q.coat_normal, at)),
        coat_basis_(basis_about(D(), coat_normal_)),
        coat_viewer_(in_coat(load3(D(), p.to_viewer, at))),
        sheen_(load3(D(), q.sheen, at)) {
    const D d;
    const V one = hn::Set(d, 1), zero = hn::Zero(d);
    coat_ = hn::Load(d, q.coat + at);
    coat_roughness_ = hn::Load(d, q.coat_roughness + at);
    coat_alpha_ = alpha_of(coat_roughness_);
    sheen_roughness_ = hn::Max(hn::Load(d, q.sheen_roughness + at), hn::Set(d, kSheenRoughnessMin));
    sheen_power_ = hn::Div(one, hn::Mul(sheen_roughness_, sheen_roughness_));
    coat_to_viewer_ = coat_albedo(coat_viewer_.z);
    fibres_to_viewer_ = fibres_albedo(base_.viewer_z());
    sheen_to_viewer_ = hn::Mul(largest(sheen_), hn::Min(fibres_to_viewer_, one));
    const V below_coat = hn::Sub(one, coat_to_viewer_);
    const V sheen =
        hn::Mul(hn::Mul(hn::Add(hn::Add(sheen_.x, sheen_.y), sheen_.z), hn::Set(d, 1 / 3.0f)),
                hn::Mul(hn::Min(fibres_to_viewer_, one), below_coat));
    const V rest = hn::Mul(hn::Mul(base_.whole(), hn::Sub(one, sheen_to_viewer_)), below_coat);
    const V whole = hn::Add(hn::Add(coat_to_viewer_, sheen), rest);
    const auto is_any = hn::Gt(whole, zero);
    coat_share_ = hn::IfThenElseZero(is_any, hn::Div(coat_to_viewer_, whole));
    sheen_share_ = hn::IfThenElseZero(is_any, hn::Div(sheen, whole));
  }

  HWY_INLINE Value evaluate(V3 to_light) const {
    const D d;
    const V one = hn::Set(d, 1), zero = hn::Zero(d);
    const V3 light = base_.local(to_light), coat_light = in_coat(to_light);
    const Value base = base_.evaluate_local(light), coat = evaluate_coat(coat_light);
    const V below_coat = hn::Sub(one, hn::Max(coat_to_viewer_, coat_albedo(coat_light.z)));
    const V fibres_to_light = fibres_albedo(light.z);
    const V sheen_to_light = hn::Mul(largest(sheen_), hn::Min(fibres_to_light, one));
    const V below_sheen = hn::Sub(one, hn::Max(sheen_to_viewer_, sheen_to_light));
    // Of fibres that would send back more than comes, so much as that they do not.
    const V most = hn::Max(one, hn::Max(fibres_to_viewer_, fibres_to_light));
    // By the cosine to the surface's normal, which the value will be multiplied by.
    const V3 of_coat = coat.times_pi * hn::Div(coat_light.z, light.z);
    const V3 below = base.times_pi * below_sheen + sheen_ * hn::Div(sheen_times_pi(light), most);
    const V3 all = of_coat + below * below_coat;
    const V base_share = hn::Sub(hn::Sub(one, coat_share_), sheen_share_);
    const V even = hn::Mul(hn::Set(d, kInvPi), light.z);
    const V pdf = hn::Add(hn::Mul(coat_share_, coat.pdf),
                          hn::Add(hn::Mul(sheen_share_, even), hn::Mul(base_share, base.pdf)));
    const auto is_above = hn::And(hn::Gt(light.z, zero), hn::Gt(base_.viewer_z(), zero));
    return {if_then_else(is_above, all, V3{zero, zero, zero}), hn::IfThenElseZero(is_above, pdf)};
  }

  HWY_INLINE Sample sample(V x, V y) const {
    const D d;
    const V one = hn::Set(d, 1), zero = hn::Zero(d), below_one = hn::Set(d, 1 - kRoundoff);
    const V layers = hn::Add(coat_share_, sheen_share_);
    const auto is_coat = hn::Lt(x, coat_share_), is_base = hn::Ge(x, layers);
    const auto within = [&](V from, V share) {
      return hn::Min(hn::Max(hn::Div(hn::Sub(x, from), share), zero), below_one);
    };
    const V3 half = visible_normal(coat_viewer_, coat_alpha_, within(zero, coat_share_), y);
    const V3 mirrored = half * hn::Mul(hn::Set(d, 2), dot(coat_viewer_, half)) - coat_viewer_;
    const V3 even = cosine_direction(d, V3{zero, zero, one}, within(coat_share_, sheen_share_), y);
    const V3 of_base = base_.sample_local(within(layers, hn::Sub(one, layers)), y);
    const V3 direction = normalize(if_then_else(is_coat, from_coat(mirrored),
                                                base_.world(if_then_else(is_base, of_base, even))));
    const Value value = evaluate(direction);
    const auto is_there = hn::Gt(value.pdf, zero);
    const V cosine = base_.local(direction).z;
    const V3 weight = value.times_pi * hn::Div(hn::Mul(hn::Set(d, kInvPi), cosine), value.pdf);
    return {direction, if_then_else(is_there, weight, V3{zero, zero, zero}),
            hn::IfThenElseZero(is_there, value.pdf)};
  }

 private:
  // About the shading normal; x along the tangent where the facets are stretched.
  static HWY_INLINE Basis<D> frame_of(const BsdfPoints& p, const LobePoints& q, size_t at) {
    const D d;
    const V3 normal = load3(d, p.normal, at), tangent = load3(d, q.tangent, at);
    const auto is_stretched = hn::Gt(hn::Load(d, q.stretch + at), hn::Zero(d));
    const Basis<D> any = basis_about(d, normal);
    return {if_then_else(is_stretched, tangent, any.tangent),
            if_then_else(is_stretched, cross(normal, tangent), any.bitangent)};
  }

  HWY_INLINE V3 in_coat(V3 world) const {
    return {dot(coat_basis_.tangent, world), dot(coat_basis_.bitangent, world),
            dot(coat_normal_, world)};
  }
  HWY_INLINE V3 from_coat(V3 v) const {
    return coat_basis_.tangent * v.x + coat_basis_.bitangent * v.y + coat_normal_ * v.z;
  }

  // What the layers take of light from a direction.
  HWY_INLINE V coat_albedo(V cosine) const {
    const SpecularAlbedo a = facets_table_.at(hn::Max(cosine, hn::Zero(D())), coat_roughness_);
    return hn::Mul(coat_, hn::Add(hn::Mul(hn::Set(D(), kCoatF0), a.scale), a.bias));
  }
  // Of white ones; may be above 1.
  HWY_INLINE V fibres_albedo(V cosine) const {
    return sheen_table_.at(hn::Max(cosine, hn::Zero(D())), sheen_roughness_).scale;
  }

  HWY_INLINE Value evaluate_coat(V3 light) const {
    const D d;
    const V zero = hn::Zero(d), one = hn::Set(d, 1), f0 = hn::Set(d, kCoatF0);
    const V3 half = normalize(light + coat_viewer_);
    const V rise = schlick_rise(dot(coat_viewer_, half));
    const V fresnel = hn::Mul(coat_, hn::Add(f0, hn::Mul(hn::Sub(one, f0), rise)));
    const V distribution = ggx_distribution(half, coat_alpha_);
    const V root_viewer = smith_root(coat_viewer_.z, coat_alpha_);
    const V root_light = smith_root(light.z, coat_alpha_);
    const V shadowed = hn::Add(hn::Mul(root_viewer, light.z), hn::Mul(root_light, coat_viewer_.z));
    const V facets = hn::Div(distribution, hn::Mul(hn::Set(d, 2 * kInvPi), shadowed));
    const auto is_above = hn::And(hn::Gt(light.z, zero), hn::Gt(coat_viewer_.z, zero));
    const V value = hn::IfThenElseZero(is_above, hn::Mul(fresnel, facets));
    const V pdf =
        hn::Div(distribution, hn::Mul(hn::Set(d, 2), hn::Add(coat_viewer_.z, root_viewer)));
    return {{value, value, value}, hn::IfThenElseZero(is_above, pdf)};
  }

  // For a white one.
  HWY_INLINE V sheen_times_pi(V3 light) const {
    const D d;
    const V one = hn::Set(d, 1), zero = hn::Zero(d), v = base_.viewer_z();
    const V3 half = normalize(light + base_.viewer());
    const V sine2 = hn::Max(hn::Sub(one, hn::Mul(half.z, half.z)), zero);
    const V fibres = power(d, sine2, hn::Mul(hn::Set(d, 0.5f), sheen_power_));
    const V distribution = hn::Mul(hn::Add(hn::Set(d, 2), sheen_power_), fibres);
    const V seen = hn::Sub(hn::Add(light.z, v), hn::Mul(light.z, v));
    const V value = hn::Div(distribution, hn::Mul(hn::Set(d, 8), seen));
    return hn::IfThenElseZero(hn::And(hn::Gt(light.z, zero), hn::Gt(v, zero)), value);
  }

  AlbedoLookup facets_table_, sheen_table_;
  Base base_;
  V3 coat_normal_;
  Basis<D> coat_basis_;
  V3 coat_viewer_;  // in its frame
  V3 sheen_;
  V coat_, coat_roughness_, coat_alpha_;
  V sheen_roughness_, sheen_power_;
  V coat_to_viewer_, sheen_to_viewer_;  // what they take of its light
  V fibres_to_viewer_;                  // likewise, white ones; may be above 1
  V coat_share_, sheen_share_;          // of samples
};

// To points.value and points.pdf.
inline void evaluate_layered(const LobeTables& tables, const LobePoints& lobes, BsdfPoints& p) {
  const ShadeTag d;
  for (int i = 0; i < p.count; i += static_cast<int>(hn::Lanes(d))) {
    const auto at = static_cast<size_t>(i);
    const auto v = LayeredLobes(tables, p, lobes, at).evaluate(load3(d, p.direction, at));
    store3(d, v.times_pi, p.value, at);
    hn::Store(v.pdf, d, p.pdf + at);
  }
}

// To points.direction, value and pdf.
inline void sample_layered(const LobeTables& tables, const LobePoints& lobes, BsdfPoints& p) {
  const ShadeTag d;
  for (int i = 0; i < p.count; i += static_cast<int>(hn::Lanes(d))) {
    const auto at = static_cast<size_t>(i);
    const auto s = LayeredLobes(tables, p, lobes, at)
                       .sample(hn::Load(d, p.square[0] + at), hn::Load(d, p.square[1] + at));
    store3(d, s.direction, p.direction, at);
    store3(d, s.weight, p.value, at);
    hn::Store(s.pdf, d, p.pdf + at);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
