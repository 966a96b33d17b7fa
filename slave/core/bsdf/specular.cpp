#include "slave/core/bsdf/specular.h"

#include "slave/core/bsdf/dielectric.h"

namespace tessera::core {
namespace {

Vec3f reflected(Vec3f to_viewer, Vec3f normal) {
  return normalize(normal * (2 * dot(normal, to_viewer)) - to_viewer);
}

// About the shading normal; where that would lead into the surface, about the geometric one, so that
// no light is lost.
Vec3f mirror_direction(const Surface& s, Vec3f to_viewer) {
  const Vec3f d = reflected(to_viewer, s.shading_normal);
  return dot(d, s.normal) > 0 ? d : reflected(to_viewer, s.normal);
}

SpecularSample sample_glass(const Surface& s, Vec3f to_viewer, float choice) {
  const float ior = s.is_front ? s.material->ior : 1 / s.material->ior;
  Vec3f normal = s.shading_normal;
  Refraction r = refraction(dot(normal, to_viewer), ior);
  if (r.reflectance < 1 && !(dot(refracted(to_viewer, normal, r), s.normal) < 0)) {
    normal = s.normal;
    r = refraction(dot(normal, to_viewer), ior);
  }
  if (choice < r.reflectance) return {mirror_direction(s, to_viewer), {1, 1, 1}, false};
  return {refracted(to_viewer, normal, r), s.material->specular, true};
}

}  // namespace

SpecularSample sample_specular(const Surface& s, Vec3f to_viewer, float choice) {
  if (s.bsdf == BsdfKind::kGlass) return sample_glass(s, to_viewer, choice);
  return {mirror_direction(s, to_viewer), s.material->specular, false};
}

}  // namespace tessera::core
