// SPDX-License-Identifier: Apache-2.0
// The optional lobes of a glossy surface, at a point: of materials that have any
// (common/scene/scene.h).
// Threads. Plain values.
#pragma once

#include "common/scene/scene.h"

namespace tessera::core {

// Unit vectors, in world space.
struct SurfaceLobes {
  Vec3f specular;          // reflectance where it is no metal, at normal incidence
  float specular_f90 = 1;  // likewise, at grazing incidence
  float coat = 0;          // share of the surface with varnish
  float coat_roughness = 0;
  Vec3f coat_normal;  // on the viewer's side
  Vec3f sheen;        // colour
  float sheen_roughness = 0;
  float stretch = 0;  // strength of anisotropy
  Vec3f tangent;  // along which the microfacet lobe is longer; perpendicular to the shading normal
};

inline bool has_coat(const Material& m) { return m.clearcoat.weight > 0; }
inline bool has_sheen(const Material& m) { return !is_black(m.sheen.color); }
inline bool is_stretched(const Material& m) { return m.anisotropy.strength > 0; }

// Whether the material asks for more than the plain glossy BSDF (slave/core/bsdf/glossy-inl.h) has.
inline bool has_lobes(const Material& m) {
  return m.bsdf == BsdfKind::kGlossy &&
         (m.specular_f90 != 1 || m.specular_texture.is_set() || m.specular_color_texture.is_set() ||
          has_coat(m) || has_sheen(m) || is_stretched(m));
}

// Whether a glossy surface passes light; glass, which always does, is not meant.
inline bool passes_light(const Material& m) {
  return m.bsdf == BsdfKind::kGlossy && m.transmission.weight > 0;
}

// Whether it is glass, or a surface that passes light, with an inside that dims light.
inline bool absorbs(const Material& m) {
  return (m.bsdf == BsdfKind::kGlass || passes_light(m)) && !m.transmission.is_thin &&
         m.transmission.attenuation_distance > 0;
}

}  // namespace tessera::core
