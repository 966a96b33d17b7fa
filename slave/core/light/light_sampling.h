// SPDX-License-Identifier: Apache-2.0
// The falloff of spots and points on emitters, for everything that samples lights.
// Threads. Pure functions.
#pragma once

#define TESSERA_PLAIN_TEXT

#include "slave/core/light/emitter-inl.h"
#include "slave/core/light/light_set.h"
#include "slave/core/light/patch_emitter.h"
#include "slave/core/light/spot-inl.h"
#include "slave/core/surface/surface_offset.h"

namespace tessera::core {

inline float spot_falloff(const Light& light, float cosine) {
  return plain::spot_falloff(light.cos_inner, light.cos_outer, cosine);
}

struct EmitterPoint {
  SurfacePoint at;
  Vec3f emission;
  Vec3f normal;
  float area;  // one over the pdf by area
};

inline EmitterPoint point_on(const LightSet& lights, const Emitter& emitter, Vec2f square) {
  if (emitter.is_patch()) {
    const PatchEmitterPoint on = sample_on_patch(*lights.patches, emitter, square);
    return {surface_point(on.point, {}, {}, on.normal, 0.0f, 0.0f),
            lights.emission_at(emitter, on.u, on.v), on.normal, on.area};
  }
  const auto [u, v] = plain::point_on_triangle(square.x, square.y);
  return {surface_point(emitter.a, emitter.edge_b, emitter.edge_c, emitter.normal, u, v),
          lights.emission_at(emitter, u, v), emitter.normal, emitter.area};
}

}  // namespace tessera::core
