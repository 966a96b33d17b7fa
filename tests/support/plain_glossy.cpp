// SPDX-License-Identifier: Apache-2.0
#include "tests/support/plain_glossy.h"

#include <algorithm>
#include <cmath>

#include "common/math/rounding.h"
#include "slave/core/bsdf/albedo_table.h"
#include "slave/core/bsdf/microfacet.h"

namespace tessera::test {
namespace {

using core::AlbedoTable;
using core::SpecularAlbedo;

constexpr int kNodes = AlbedoTable::kNodes;
constexpr float kInvPi = 0.318309886f;

float mean(Vec3f c) { return (c.x + c.y + c.z) * (1 / 3.0f); }
Vec3f grey(float x) { return {x, x, x}; }

// a / b by channel; 0 where b is next to nothing, since the facets take all there and a is nothing,
// too.
Vec3f ratio(Vec3f a, Vec3f b) {
  const auto one = [](float x, float y) { return y > gamma(16) ? x / y : 0; };
  return {one(a.x, b.x), one(a.y, b.y), one(a.z, b.z)};
}

// GGX: area of facets per area of the surface and solid angle of their normals.
inline float ggx_distribution(Vec3f half, float alpha) {
  const float x = half.x / alpha, y = half.y / alpha;
  const float norm = x * x + y * y + half.z * half.z;
  return 0.318309886f / (alpha * alpha * norm * norm);
}

// The node below `x` in [0, 1] and the weight of the next.
struct Step {
  std::size_t node;
  float weight;
};
Step step_of(float x) {
  const float at = std::clamp(x, 0.0f, 1.0f) * (kNodes - 1);
  const int node = std::min(static_cast<int>(at), kNodes - 2);
  return {static_cast<std::size_t>(node), at - static_cast<float>(node)};
}

SpecularAlbedo mixed(SpecularAlbedo a, SpecularAlbedo b, float t) {
  return {a.scale * (1 - t) + b.scale * t, a.bias * (1 - t) + b.bias * t};
}

// The i-th of the pairs of a table.
SpecularAlbedo pair(const float* table, std::size_t i) { return {table[2 * i], table[2 * i + 1]}; }

// Mean of the albedo over all directions, cosine-weighted.
SpecularAlbedo mean_albedo(float roughness) {
  const Step r = step_of(roughness);
  const float* const means = AlbedoTable::shared().view().means;
  return mixed(pair(means, r.node), pair(means, r.node + 1), r.weight);
}

float missing(SpecularAlbedo a) { return std::max(0.0f, 1 - (a.scale + a.bias)); }

// Albedo of multiple scattering: of light that stays between facets after the first bounce, what
// comes out in the end. The mean of Schlick's term over all directions is f0 + (1 - f0) / 21, and
// light meets it at every bounce.
Vec3f several_albedo(Vec3f f0, SpecularAlbedo all) {
  const Vec3f fresnel = f0 + (grey(1) - f0) * (1 / 21.0f);
  return ratio(fresnel * fresnel * (1 - missing(all)), grey(1) - fresnel * missing(all));
}

// Share of light that facets leave for the base, once for the way in and once for the way out. It
// is not below 0 by rounding.
Vec3f left_of(SpecularAlbedo a, const PlainGlossy::Facets& f) {
  return max(grey(1) - (f.f0 * a.scale + grey(a.bias) + f.several_albedo * missing(a)), Vec3f{});
}

}  // namespace

PlainGlossy::PlainGlossy(const core::Surface& s, Vec3f to_viewer)
    : normal_(s.shading_normal),
      basis_(core::basis_about(s.shading_normal)),
      viewer_(local(to_viewer)),
      roughness_(s.roughness),
      alpha_(core::alpha_of(s.roughness)),
      f0_(s.material->specular * (1 - s.metalness) + s.albedo * s.metalness) {
  const SpecularAlbedo here = plain_albedo(viewer_.z, roughness_), all = mean_albedo(roughness_);
  const Vec3f of_dielectric = several_albedo(s.material->specular, all);
  const Vec3f of_metal = s.metalness > 0 ? several_albedo(s.albedo, all) : Vec3f{};
  several_albedo_ = of_dielectric * (1 - s.metalness) + of_metal * s.metalness;
  several_ = ratio(several_albedo_ * missing(here), grey(missing(all)));
  dielectric_ = {s.material->specular, of_dielectric};
  const Vec3f body = s.albedo * (1 - s.metalness);
  const Vec3f passed = left_of(here, dielectric_);
  base_ = body * ratio(passed, left_of(all, dielectric_));
  const float facets = mean(f0_) * here.scale + here.bias;
  const float even = mean(several_albedo_) * missing(here) + mean(body * passed);
  facets_share_ = facets + even > 0 ? facets / (facets + even) : 1;
}

Vec3f PlainGlossy::local(Vec3f world) const {
  return {dot(basis_.tangent, world), dot(basis_.bitangent, world), dot(normal_, world)};
}

BsdfValue PlainGlossy::evaluate(Vec3f to_light) const { return evaluate_local(local(to_light)); }

BsdfValue PlainGlossy::evaluate_local(Vec3f light) const {
  if (!(light.z > 0 && viewer_.z > 0)) return {};
  const Vec3f half = normalize(light + viewer_);
  const Vec3f fresnel = f0_ + (grey(1) - f0_) * core::schlick_rise(dot(viewer_, half));
  const float distribution = ggx_distribution(half, alpha_);
  const float root_viewer = core::smith_root(viewer_.z, alpha_),
              root_light = core::smith_root(light.z, alpha_);
  const float facets =
      distribution / (2 * kInvPi * (root_viewer * light.z + root_light * viewer_.z));
  const SpecularAlbedo there = plain_albedo(light.z, roughness_);
  BsdfValue value;
  value.times_pi =
      fresnel * facets + several_ * missing(there) + base_ * left_of(there, dielectric_);
  value.pdf = facets_share_ * distribution / (2 * (viewer_.z + root_viewer)) +
              (1 - facets_share_) * kInvPi * light.z;
  return value;
}

BsdfSample PlainGlossy::sample(Vec2f square) const {
  constexpr float kBelowOne = 1 - kUnitRoundoff;
  Vec3f light;
  if (square.x < facets_share_) {
    const Vec2f x{std::min(square.x / facets_share_, kBelowOne), square.y};
    const Vec3f half = core::visible_normal(viewer_, alpha_, x);
    light = normalize(half * (2 * dot(viewer_, half)) - viewer_);
  } else {
    const Vec2f x{std::min((square.x - facets_share_) / (1 - facets_share_), kBelowOne), square.y};
    light = core::cosine_direction({0, 0, 1}, x);
  }
  const BsdfValue value = evaluate_local(light);
  BsdfSample result;
  result.direction =
      normalize(basis_.tangent * light.x + basis_.bitangent * light.y + normal_ * light.z);
  if (!(value.pdf > 0)) return result;
  result.pdf = value.pdf;
  result.weight = value.times_pi * (kInvPi * light.z / value.pdf);
  return result;
}

}  // namespace tessera::test
