// SPDX-License-Identifier: Apache-2.0
// The GGX distribution of microfacets with height-correlated Smith shadowing (Walter et al.,
// "Microfacet models for refraction through rough surfaces", 2007; Heitz, "Understanding the
// masking-shadowing function", JCGT 3(2), 2014). Directions are unit vectors in the frame of the
// normal, z along it; z > 0.
//
// With s(w) = sqrt(z^2 + alpha^2 (1 - z^2)), Smith's 2 z (1 + Lambda) is z + s: the formulas below
// have no tangent and stay finite to z = 0.
//
// Threads. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/math/vec3.h"
#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {

// Narrower lobes are taken for this: half vectors are off by some 2^-23, which shifts the
// distribution by 2 * 2^-23 / alpha of itself, here 2.4e-4.
inline constexpr float kAlphaMin = 1e-3f;

inline float alpha_of(float roughness) { return std::max(roughness * roughness, kAlphaMin); }

inline float smith_root(float z, float alpha) {
  return std::sqrt(z * z + alpha * alpha * (1 - z * z));
}

// What shadowing leaves of a reflection, over its pdf when the half vector is a visible normal:
// G2 / G1.
inline float shadowing_weight(float z_viewer, float z_light, float alpha) {
  const float root_viewer = smith_root(z_viewer, alpha), root_light = smith_root(z_light, alpha);
  return z_light * (z_viewer + root_viewer) / (root_viewer * z_light + root_light * z_viewer);
}

// A normal that the viewer sees, by the pdf of visible normals (Dupuy and Benyoub, "Sampling visible
// GGX normals with spherical caps", 2023).
inline Vec3f visible_normal(Vec3f to_viewer, float alpha, Vec2f x) {
  const Vec3f v = normalize({to_viewer.x * alpha, to_viewer.y * alpha, to_viewer.z});
  const float z = (1 - x.y) * (1 + v.z) - v.z;
  const float r = std::sqrt(std::clamp(1 - z * z, 0.0f, 1.0f));
  const SinCos turn = sin_cos_whole_turn(x.x);
  const Vec3f half{r * turn.cos + v.x, r * turn.sin + v.y, z + v.z};
  return normalize({half.x * alpha, half.y * alpha, std::max(half.z, 0.0f)});
}

// (1 - x)^5, the rise of Fresnel's reflectance towards grazing angles (Schlick, "An inexpensive BRDF
// model for physically-based rendering", 1994).
inline float schlick_rise(float cosine) {
  const float x = std::clamp(1 - cosine, 0.0f, 1.0f);
  return x * x * (x * x) * x;
}

}  // namespace tessera::core
