// SPDX-License-Identifier: Apache-2.0
// What one light sheds where: shared by everything that samples lights.
// Threads. Pure functions.
#pragma once

#include <cmath>

#include "slave/core/light/light_set.h"
#include "slave/core/surface/surface_offset.h"

namespace tessera::core {

// 0 below the outer cone, 1 within the inner; between them the square of what is linear in the cosine
// (KHR_lights_punctual, "Inner and outer cone angles"). at_light() in vpl_gather-inl.h has the same.
inline float spot_falloff(const Light& light, float cosine) {
  if (!(cosine > light.cos_outer)) return 0;
  if (cosine >= light.cos_inner) return 1;
  const float x = (cosine - light.cos_outer) / (light.cos_inner - light.cos_outer);
  return x * x;
}

struct EmitterPoint {
  SurfacePoint at;
  Vec3f emission;
};

// Uniform on the triangle (Osada et al., "Shape distributions", 2002, section 4.2); keeps strata.
inline EmitterPoint point_on(const LightSet& lights, const Emitter& emitter, Vec2f square) {
  const float root = std::sqrt(square.x);
  const float u = root * (1 - square.y), v = root * square.y;
  return {surface_point(emitter.a, emitter.edge_b, emitter.edge_c, emitter.normal, u, v),
          lights.emission_at(emitter, u, v)};
}

}  // namespace tessera::core
