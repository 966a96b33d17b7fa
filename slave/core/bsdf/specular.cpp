// SPDX-License-Identifier: Apache-2.0
#include "slave/core/bsdf/specular.h"

#include <algorithm>

#include "slave/core/bsdf/albedo_table.h"
#include "slave/core/bsdf/dielectric.h"
#include "slave/core/bsdf/microfacet.h"
#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {
namespace {

Vec3f reflected(Vec3f to_viewer, Vec3f normal) {
  return normalize(normal * (2 * dot(normal, to_viewer)) - to_viewer);
}

// Reflects about the shading normal, or, where that would lead into the surface, about the
// geometric one, so that no light is lost.
Vec3f mirror_direction(const Surface& s, Vec3f to_viewer) {
  const Vec3f d = reflected(to_viewer, s.shading_normal);
  return dot(d, s.normal) > 0 ? d : reflected(to_viewer, s.normal);
}

// The properties of glass where a ray meets it.
struct Glass {
  Vec3f tint;  // of transmitted light
  float ior;   // of the far side, relative to the viewer's
  float alpha = 0;
  bool is_thin = false;

  explicit Glass(const Surface& s) {
    const Material& m = *s.material;
    const bool is_kind = m.bsdf == BsdfKind::kGlass;
    is_thin = !is_kind && m.transmission.is_thin;
    tint = is_kind ? m.specular : s.albedo;
    ior = s.is_front || is_thin ? m.ior : 1 / m.ior;
    const float width = s.roughness * s.roughness;
    if (!is_kind && width > kAlphaMin) alpha = width;
  }
};

SpecularSample sample_smooth(const Surface& s, const Glass& glass, Vec3f to_viewer, float choice) {
  Vec3f normal = s.shading_normal;
  Refraction r = refraction(dot(normal, to_viewer), glass.ior);
  if (!glass.is_thin && r.reflectance < 1 &&
      !(dot(refracted(to_viewer, normal, r), s.normal) < 0)) {
    normal = s.normal;
    r = refraction(dot(normal, to_viewer), glass.ior);
  }
  if (choice < r.reflectance) return {mirror_direction(s, to_viewer), {1, 1, 1}, false};
  const Vec3f onward = glass.is_thin ? -to_viewer : refracted(to_viewer, normal, r);
  return {onward, glass.tint, true};
}

class RoughGlass {
 public:
  RoughGlass(const Surface& s, const Glass& glass, Vec3f to_viewer)
      : surface_(s), glass_(glass), basis_(basis_about(s.shading_normal)) {
    viewer_ = {dot(basis_.tangent, to_viewer), dot(basis_.bitangent, to_viewer),
               dot(s.shading_normal, to_viewer)};
    if (!glass.is_thin) return;
    const SpecularAlbedo kept =
        albedo_at(AlbedoTable::shared().view(), viewer_.z, surface_.roughness);
    whole_ = 1 / std::max(kept.scale + kept.bias, 0.1f);
  }

  SpecularSample sample(Vec2f square) const {
    // The chance to reflect is the reflectance of the smooth surface. Facets whose own reflectance
    // differs much from it are rare, and the bounds of the chance limit what they weigh.
    const float even = refraction(viewer_.z, glass_.ior).reflectance;
    const float reflecting = surface_.passes_only ? 0 : std::clamp(even, 0.1f, 0.9f);
    const bool reflects = square.x < reflecting;
    const float x = reflects ? square.x / reflecting : (square.x - reflecting) / (1 - reflecting);
    const Vec3f half = visible_normal(viewer_, glass_.alpha, {std::min(x, kBelowOne), square.y});
    const Refraction r = refraction(dot(viewer_, half), glass_.ior);
    Vec3f light = mirrored(half);
    if (reflects) {
      const float back = r.reflectance / reflecting * lit(light);
      return {world(light), {back, back, back}, false, glass_.alpha};
    }
    float kept = 0;
    if (glass_.is_thin) {
      kept = lit(light);
      light.z = -light.z;
    } else if (r.reflectance < 1) {
      light = refracted(viewer_, half, r);
      kept = light.z < 0 ? shadowed(-light.z) : 0;
    }
    const float passed = (1 - r.reflectance) / (1 - reflecting) * kept;
    return {world(light), glass_.tint * passed, true, glass_.alpha};
  }

 private:
  static constexpr float kBelowOne = 1 - 0x1p-24f;
  Vec3f mirrored(Vec3f half) const { return normalize(half * (2 * dot(viewer_, half)) - viewer_); }
  // What shadowing leaves of a reflection, over the pdf of the half vector.
  float lit(Vec3f light) const {
    return light.z > 0 ? whole_ * shadowing_weight(viewer_.z, light.z, glass_.alpha) : 0;
  }
  // What shadowing leaves on the far side, where it is independent of the masking from the viewer.
  float shadowed(float z) const { return 2 * z / (z + smith_root(z, glass_.alpha)); }
  Vec3f world(Vec3f v) const {
    return normalize(basis_.tangent * v.x + basis_.bitangent * v.y + surface_.shading_normal * v.z);
  }

  const Surface& surface_;
  const Glass& glass_;
  const Basis<float> basis_;
  Vec3f viewer_;  // in the frame of the shading normal
  float whole_ = 1;
};

SpecularSample sample_mirror(const Surface& s, Vec3f to_viewer, Vec2f) {
  return {mirror_direction(s, to_viewer), s.material->specular, false};
}

SpecularSample sample_glass(const Surface& s, Vec3f to_viewer, Vec2f square) {
  const Glass glass(s);
  if (glass.alpha > 0) return RoughGlass(s, glass, to_viewer).sample(square);
  return sample_smooth(s, glass, to_viewer, square.x);
}

// The BSDFs that scatter into single directions.
struct Row {
  BsdfKind kind;
  SpecularSample (*sample)(const Surface& s, Vec3f to_viewer, Vec2f square);
};
constexpr Row kRows[] = {{BsdfKind::kMirror, sample_mirror}, {BsdfKind::kGlass, sample_glass}};

}  // namespace

SpecularSample sample_specular(const Surface& s, Vec3f to_viewer, Vec2f square) {
  for (const Row& row : kRows) {
    if (row.kind == s.bsdf) return row.sample(s, to_viewer, square);
  }
  return {s.normal, {}};  // not a BSDF that scatters into single directions
}

}  // namespace tessera::core
