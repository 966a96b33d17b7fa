// SPDX-License-Identifier: Apache-2.0
// How wide a pixel's view is at a surface: a cone about the ray, for filtering what varies over the
// surface (Akenine-Moeller et al., "Texture level of detail strategies for real-time ray tracing",
// Ray Tracing Gems, 2019, chapter 20; "Improved shader and texture level of detail using ray
// cones", JCGT 10(1), 2021). Curvature of mirrors is not followed: behind a bent one the cone is
// that of a flat one.
//
// Threads. Plain values.
#pragma once

namespace tessera::core {

struct RayCone {
  float width = 0;   // at the ray's point, world units
  float spread = 0;  // by which it widens for each unit of length

  RayCone advanced(float distance) const { return {width + spread * distance, spread}; }
  // The cone after scattering that is `by` wider than a mirror's.
  RayCone widened(float by) const { return {width, spread + by}; }
};

}  // namespace tessera::core
