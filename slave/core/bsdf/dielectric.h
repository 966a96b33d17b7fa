// SPDX-License-Identifier: Apache-2.0
// A smooth interface between two transparent media (Born and Wolf, "Principles of optics", section
// 1.5): Snell's law and Fresnel's reflectance of unpolarised light.
//
// Threads. Pure functions.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/math/vec3.h"

namespace tessera::core {

struct Refraction {
  float reflectance = 1;  // in [0, 1]; 1 is total reflection, and there is nothing beyond
  float cosine = 0;       // of the refracted ray and the normal, on the far side
  float ior = 1;          // as given
};

// cosine: of the angle between viewer and normal. ior: of the far side, relative to the viewer's;
// positive.
inline Refraction refraction(float cosine, float ior) {
  const float near = std::clamp(cosine, 0.0f, 1.0f);
  const float sine2 = (1 - near * near) / (ior * ior);
  if (!(sine2 < 1)) return {1, 0, ior};
  const float far = std::sqrt(1 - sine2);
  const float parallel = (ior * near - far) / (ior * near + far);
  const float crossed = (near - ior * far) / (near + ior * far);
  return {std::min(1.0f, (parallel * parallel + crossed * crossed) / 2), far, ior};
}

// Returns: the direction of the refracted ray, unit. Requires: r was computed for this viewer and
// normal, and is no total reflection.
inline Vec3f refracted(Vec3f to_viewer, Vec3f normal, const Refraction& r) {
  const float cosine = dot(normal, to_viewer);
  return normalize(normal * (cosine / r.ior - r.cosine) - to_viewer * (1 / r.ior));
}

}  // namespace tessera::core
