#include "slave/core/bsdf/bsdf.h"

#include "slave/core/bsdf/dielectric.h"
#include "slave/core/bsdf/glossy.h"
#include "slave/core/sampling/hemisphere.h"

namespace tessera::core {
namespace {

constexpr float kInvPi = 0.318309886f;

Vec3f reflected(Vec3f to_viewer, Vec3f normal) {
  return normalize(normal * (2 * dot(normal, to_viewer)) - to_viewer);
}

// About the shading normal; where that would lead into the surface, about the geometric one, so that
// no light is lost.
Vec3f mirror_direction(const Surface& s, Vec3f to_viewer) {
  const Vec3f d = reflected(to_viewer, s.shading_normal);
  return dot(d, s.normal) > 0 ? d : reflected(to_viewer, s.normal);
}

BsdfSample delta(Vec3f direction, Vec3f weight, bool is_through) {
  return {direction, weight, 0, true, is_through};
}

BsdfSample sample_glass(const Surface& s, Vec3f to_viewer, float x) {
  const float ior = s.is_front ? s.material->ior : 1 / s.material->ior;
  Vec3f normal = s.shading_normal;
  Refraction r = refraction(dot(normal, to_viewer), ior);
  if (r.reflectance < 1 && !(dot(refracted(to_viewer, normal, r), s.normal) < 0)) {
    normal = s.normal;
    r = refraction(dot(normal, to_viewer), ior);
  }
  if (x < r.reflectance) return delta(mirror_direction(s, to_viewer), {1, 1, 1}, false);
  return delta(refracted(to_viewer, normal, r), s.material->specular, true);
}

}  // namespace

BsdfValue evaluate(const Surface& s, Vec3f to_viewer, Vec3f to_light) {
  switch (s.bsdf) {
    case BsdfKind::kDiffuse:
      return {s.albedo, kInvPi * dot(s.shading_normal, to_light)};
    case BsdfKind::kGlossy:
      return GlossyLobes(s, to_viewer).evaluate(to_light);
    case BsdfKind::kMirror:
    case BsdfKind::kGlass:
      break;
  }
  return {};
}

BsdfSample sample(const Surface& s, Vec3f to_viewer, Vec2f square) {
  switch (s.bsdf) {
    case BsdfKind::kDiffuse: {
      const Vec3f direction = cosine_direction(s.shading_normal, square);
      return {direction, s.albedo, kInvPi * dot(s.shading_normal, direction), false, false};
    }
    case BsdfKind::kGlossy:
      return GlossyLobes(s, to_viewer).sample(square);
    case BsdfKind::kMirror:
      return delta(mirror_direction(s, to_viewer), s.material->specular, false);
    case BsdfKind::kGlass:
      return sample_glass(s, to_viewer, square.x);
  }
  return {};
}

}  // namespace tessera::core
