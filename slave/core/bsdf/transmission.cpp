// SPDX-License-Identifier: Apache-2.0
#include "slave/core/bsdf/transmission.h"

#include <algorithm>

#include "slave/core/bsdf/dielectric.h"
#include "slave/core/bsdf/layers.h"
#include "slave/core/bsdf/microfacet.h"
#include "slave/core/simd/power.h"

namespace tessera::core {
namespace {

bool is_layered(const SurfaceLobes* lobes) {
  return lobes != nullptr && (lobes->coat > 0 || !is_black(lobes->sheen));
}

}  // namespace

void choose_part(Surface& s, SurfaceLobes* lobes, float share, float chance) {
  const float passing = share * (1 - s.metalness), opaque = 1 - passing;
  if (!(chance >= opaque)) {
    s.metalness = std::min(1.0f, s.metalness / opaque);
    return;
  }
  const bool is_outside = s.is_front || s.material->transmission.is_thin;
  const bool is_smooth = s.roughness * s.roughness <= kAlphaMin;
  if (!is_outside || (is_smooth && !is_layered(lobes))) {
    s.bsdf = BsdfKind::kGlass;
    s.lobes = kNoLobes;
    return;
  }
  const float reflectance =
      refraction(dot(s.shading_normal, s.to_viewer), s.material->ior).reflectance;
  const float reflecting = (1 + 3 * reflectance) / 4;
  if (chance - opaque < passing * reflecting) {
    s.metalness = 0;
    s.albedo = {};
    s.weight = s.weight * (1 / reflecting);
    return;
  }
  s.bsdf = BsdfKind::kGlass;
  s.passes_only = true;
  const float below =
      lobes == nullptr ? 1 : passed_by_layers(*lobes, s.shading_normal, s.to_viewer);
  s.weight = s.weight * (below / (1 - reflecting));
  s.lobes = kNoLobes;
}

Vec3f absorbed(const Transmission& inside, float distance) {
  if (inside.is_thin || !(inside.attenuation_distance > 0)) return {1, 1, 1};
  const float lengths = distance / inside.attenuation_distance;
  const Vec3f& c = inside.attenuation_color;
  return {power(c.x, lengths), power(c.y, lengths), power(c.z, lengths)};
}

}  // namespace tessera::core
