// SPDX-License-Identifier: Apache-2.0
// The GGX distribution of microfacets with height-correlated Smith shadowing (Walter et al.,
// "Microfacet models for refraction through rough surfaces", 2007; Heitz, "Understanding the
// masking-shadowing function", JCGT 3(2), 2014), and the table of what they reflect. Directions are
// unit vectors in the frame of the normal, z along it; z > 0. T: float, or Floats.
//
// With s(w) = sqrt(z^2 + alpha^2 (1 - z^2)), Smith's 2 z (1 + Lambda) is z + s: the formulas below
// have no tangent and stay finite to z = 0.
//
// Threads. Pure functions.
#include "slave/core/bsdf/albedo_layout.h"

#if defined(TESSERA_CORE_MICROFACET_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_CORE_MICROFACET_INL_H_
#undef TESSERA_CORE_MICROFACET_INL_H_
#else
#define TESSERA_CORE_MICROFACET_INL_H_
#endif

#include "slave/core/sampling/hemisphere-inl.h"

TESSERA_BEFORE_TEXT();
namespace tessera::core {
namespace TESSERA_TEXT {

// Least alpha; narrower lobes are widened to it. Half vectors are off by some 2^-23, which shifts
// the distribution by 2 * 2^-23 / alpha of itself, here 2.4e-4.
constexpr float kAlphaMin = 1e-3f;

template <class T>
TESSERA_INLINE T alpha_of(T roughness) {
  return max(roughness * roughness, kAlphaMin);
}

template <class T>
TESSERA_INLINE T smith_root(T z, T alpha) {
  return sqrt(z * z + alpha * alpha * (1 - z * z));
}

// The weight of a reflection whose half vector was drawn from the visible normals, that is what
// shadowing leaves of it, over the pdf: G2 / G1.
template <class T>
TESSERA_INLINE T shadowing_weight(T z_viewer, T z_light, T alpha) {
  const T root_viewer = smith_root(z_viewer, alpha), root_light = smith_root(z_light, alpha);
  return z_light * (z_viewer + root_viewer) / (root_viewer * z_light + root_light * z_viewer);
}

template <class T>
TESSERA_INLINE T ggx_distribution(Vec3<T> half, T alpha) {
  const T x = half.x / alpha, y = half.y / alpha;
  const T norm = x * x + y * y + half.z * half.z;
  return kInvPi / (alpha * alpha * norm * norm);
}

// Samples a normal that the viewer sees, by the pdf of visible normals (Dupuy and Benyoub,
// "Sampling visible GGX normals with spherical caps", 2023), of facets whose widths differ along x
// and y of the frame. x, y: in the unit square.
template <class T>
TESSERA_INLINE Vec3<T> visible_normal(Vec3<T> to_viewer, T alpha_x, T alpha_y, T x, T y) {
  const Vec3<T> v = normalize(Vec3<T>{to_viewer.x * alpha_x, to_viewer.y * alpha_y, to_viewer.z});
  const T z = (1 - y) * (1 + v.z) - v.z;
  const T r = sqrt(min(max(1 - z * z, 0), 1));
  const SinCos<T> turn = sin_cos_whole_turn(x);
  const Vec3<T> half{r * turn.cos + v.x, r * turn.sin + v.y, z + v.z};
  return normalize(Vec3<T>{half.x * alpha_x, half.y * alpha_y, max(half.z, 0)});
}
template <class T>
TESSERA_INLINE Vec3<T> visible_normal(Vec3<T> to_viewer, T alpha, T x, T y) {
  return visible_normal(to_viewer, alpha, alpha, x, y);
}

// (1 - x)^5, the rise of Fresnel's reflectance towards grazing angles (Schlick, "An inexpensive
// BRDF model for physically-based rendering", 1994).
template <class T>
TESSERA_INLINE T schlick_rise(T cosine) {
  const T x = min(max(1 - cosine, 0), 1);
  return x * x * (x * x) * x;
}

// The reflectance of facets with f0 at normal incidence is f0 * scale + bias (albedo_table.h).
template <class T>
struct AlbedoTerms {
  T scale, bias;
};

// The node of a table below a place, and the weight of the next node.
template <class T>
struct TableStep {
  IntOf<T> node;
  T weight;
};

// x: in [0, 1], along an axis of so many nodes.
template <class T>
TESSERA_INLINE TableStep<T> table_step(T x, int32_t node_count) {
  using I = IntOf<T>;
  const T inside = min(max(x, 0), 1);
  const T at = inside * static_cast<float>(node_count - 1);
  const I below = min(convert<I>(at), node_count - 2);
  const I node = max(below, 0);  // unused lanes may hold anything
  return {node, at - convert<T>(node)};
}

template <class T>
TESSERA_INLINE AlbedoTerms<T> mixed(AlbedoTerms<T> a, AlbedoTerms<T> b, T t) {
  const T s = 1 - t;
  return {a.scale * s + b.scale * t, a.bias * s + b.bias * t};
}

// Entry `number` of a table of pairs.
template <class T>
TESSERA_INLINE AlbedoTerms<T> pair_at(const float* table, IntOf<T> number) {
  const IntOf<T> first = number + number;
  return {gather(table, first), gather(table + 1, first)};
}

template <class T>
class AlbedoLookup {
  using I = IntOf<T>;

 public:
  explicit TESSERA_INLINE AlbedoLookup(const AlbedoView& table) : table_(table) {}

  // cosine and roughness in [0, 1].
  TESSERA_INLINE AlbedoTerms<T> at(T cosine, T roughness) const {
    const TableStep<T> i = step_of(sqrt(max(cosine, 0))), r = step_of(roughness);
    const I row = r.node * table_.node_count;
    const auto mixed_row = [&](I first) {
      const I node = first + i.node;
      return mixed(pair(table_.nodes, node), pair(table_.nodes, node + 1), i.weight);
    };
    return mixed(mixed_row(row), mixed_row(row + table_.node_count), r.weight);
  }

  // The mean over all directions, cosine-weighted.
  TESSERA_INLINE AlbedoTerms<T> mean(T roughness) const {
    const TableStep<T> r = step_of(roughness);
    return mixed(pair(table_.means, r.node), pair(table_.means, r.node + 1), r.weight);
  }

 private:
  TESSERA_INLINE TableStep<T> step_of(T x) const { return table_step(x, table_.node_count); }
  static TESSERA_INLINE AlbedoTerms<T> pair(const float* table, I number) {
    return pair_at<T>(table, number);
  }

  AlbedoView table_;
};

}  // namespace TESSERA_TEXT
}  // namespace tessera::core
TESSERA_AFTER_TEXT();

#endif  // per-target include guard
