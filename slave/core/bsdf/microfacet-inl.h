// SPDX-License-Identifier: Apache-2.0
// The GGX microfacets of bsdf/microfacet.h and the albedos of bsdf/albedo_table.h in lanes, to the bit.
// Threads. Pure functions.
#include "slave/core/bsdf/bsdf_layout.h"

#if defined(TESSERA_CORE_MICROFACET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_MICROFACET_INL_H_
#undef TESSERA_CORE_MICROFACET_INL_H_
#else
#define TESSERA_CORE_MICROFACET_INL_H_
#endif

#include "slave/core/sampling/hemisphere-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

using ShadeTag = hn::CappedTag<float, 16>;
using ShadeVec = hn::Vec<ShadeTag>;

constexpr float kAlphaMin = 1e-3f;  // see microfacet.h

HWY_INLINE ShadeVec alpha_of(ShadeVec roughness) {
  return hn::Max(hn::Mul(roughness, roughness), hn::Set(ShadeTag(), kAlphaMin));
}

HWY_INLINE ShadeVec smith_root(ShadeVec z, ShadeVec alpha) {
  const ShadeVec z2 = hn::Mul(z, z);
  return hn::Sqrt(hn::Add(z2, hn::Mul(hn::Mul(alpha, alpha), hn::Sub(hn::Set(ShadeTag(), 1), z2))));
}

HWY_INLINE ShadeVec ggx_distribution(Vec3<ShadeTag> half, ShadeVec alpha) {
  const ShadeVec x = hn::Div(half.x, alpha), y = hn::Div(half.y, alpha);
  const ShadeVec norm = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(half.z, half.z));
  return hn::Div(hn::Set(ShadeTag(), kInvPi), hn::Mul(hn::Mul(hn::Mul(alpha, alpha), norm), norm));
}

// Of facets whose widths differ along x and y of the frame.
HWY_INLINE Vec3<ShadeTag> visible_normal(Vec3<ShadeTag> to_viewer, ShadeVec alpha_x,
                                         ShadeVec alpha_y, ShadeVec x, ShadeVec y) {
  const ShadeTag d;
  const ShadeVec one = hn::Set(d, 1), zero = hn::Zero(d);
  const Vec3<ShadeTag> v = normalize(
      Vec3<ShadeTag>{hn::Mul(to_viewer.x, alpha_x), hn::Mul(to_viewer.y, alpha_y), to_viewer.z});
  const ShadeVec z = hn::Sub(hn::Mul(hn::Sub(one, y), hn::Add(one, v.z)), v.z);
  const ShadeVec r = hn::Sqrt(hn::Min(hn::Max(hn::Sub(one, hn::Mul(z, z)), zero), one));
  const auto turn = sin_cos_whole_turn(d, x);
  const ShadeVec half_x = hn::Add(hn::Mul(r, turn.cos), v.x),
                 half_y = hn::Add(hn::Mul(r, turn.sin), v.y), half_z = hn::Add(z, v.z);
  return normalize(
      Vec3<ShadeTag>{hn::Mul(half_x, alpha_x), hn::Mul(half_y, alpha_y), hn::Max(half_z, zero)});
}
HWY_INLINE Vec3<ShadeTag> visible_normal(Vec3<ShadeTag> to_viewer, ShadeVec alpha, ShadeVec x,
                                         ShadeVec y) {
  return visible_normal(to_viewer, alpha, alpha, x, y);
}

HWY_INLINE ShadeVec schlick_rise(ShadeVec cosine) {
  const ShadeTag d;
  const ShadeVec one = hn::Set(d, 1);
  const ShadeVec x = hn::Min(hn::Max(hn::Sub(one, cosine), hn::Zero(d)), one);
  const ShadeVec x2 = hn::Mul(x, x);
  return hn::Mul(hn::Mul(x2, x2), x);
}

struct SpecularAlbedo {
  ShadeVec scale, bias;
};

class AlbedoLookup {
  using D = ShadeTag;
  using DI = hn::RebindToSigned<D>;
  using V = ShadeVec;
  using VI = hn::Vec<DI>;

 public:
  explicit HWY_INLINE AlbedoLookup(const AlbedoView& table) : table_(table) {}

  // cosine and roughness in [0, 1].
  HWY_INLINE SpecularAlbedo at(V cosine, V roughness) const {
    const D d;
    const DI di;
    const Step i = step_of(hn::Sqrt(hn::Max(cosine, hn::Zero(d)))), r = step_of(roughness);
    const VI row = hn::Mul(r.node, hn::Set(di, table_.node_count));
    const auto mixed_row = [&](VI first) {
      const VI node = hn::Add(first, i.node);
      return mixed(pair(table_.nodes, node), pair(table_.nodes, hn::Add(node, hn::Set(di, 1))),
                   i.weight);
    };
    return mixed(mixed_row(row), mixed_row(hn::Add(row, hn::Set(di, table_.node_count))), r.weight);
  }

  // Over all directions, cosine-weighted.
  HWY_INLINE SpecularAlbedo mean(V roughness) const {
    const Step r = step_of(roughness);
    return mixed(pair(table_.means, r.node), pair(table_.means, hn::Add(r.node, hn::Set(DI(), 1))),
                 r.weight);
  }

 private:
  // The node below, and the weight of the next.
  struct Step {
    VI node;
    V weight;
  };

  HWY_INLINE Step step_of(V x) const {
    const D d;
    const DI di;
    const V inside = hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, 1));
    const V at = hn::Mul(inside, hn::Set(d, static_cast<float>(table_.node_count - 1)));
    const VI below = hn::Min(hn::ConvertTo(di, at), hn::Set(di, table_.node_count - 2));
    const VI node = hn::Max(below, hn::Zero(di));  // whatever lanes hold that are none
    return {node, hn::Sub(at, hn::ConvertTo(d, node))};
  }

  static HWY_INLINE SpecularAlbedo pair(const float* table, VI number) {
    const D d;
    const VI first = hn::Add(number, number);
    return {hn::GatherIndex(d, table, first), hn::GatherIndex(d, table + 1, first)};
  }

  static HWY_INLINE SpecularAlbedo mixed(SpecularAlbedo a, SpecularAlbedo b, V t) {
    const V s = hn::Sub(hn::Set(D(), 1), t);
    return {hn::Add(hn::Mul(a.scale, s), hn::Mul(b.scale, t)),
            hn::Add(hn::Mul(a.bias, s), hn::Mul(b.bias, t))};
  }

  AlbedoView table_;
};

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
