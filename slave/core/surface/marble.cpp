// SPDX-License-Identifier: Apache-2.0
// Marble: sheets of vein through the stone, `frequency` of them a unit along x, folded by
// turbulence (after Perlin, "An image synthesizer", 1985). The material's albedo is the stone.
#include <algorithm>
#include <cmath>

#include "slave/core/surface/programs.h"

namespace tessera::core {

void apply_marble(const SurfaceParameters& parameters, const Noise& noise,
                  const SurfacePlaces& places) {
  const float frequency = parameters[0], strength = parameters[1];
  const Vec3f vein{parameters[2], parameters[3], parameters[4]};
  const std::size_t count = places.surface.size();
  std::array<float, kPlacesMax> x, y, z, footprint, folds;
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = places.point[0][i] * frequency;
    y[i] = places.point[1][i] * frequency;
    z[i] = places.point[2][i] * frequency;
    footprint[i] = places.footprint[i] * frequency;
  }
  noise.turbulence({{x.data(), count}, {y.data(), count}, {z.data(), count}}, 0x6d617262u,
                   {footprint.data(), count}, {folds.data(), count});
  for (std::size_t i = 0; i < count; ++i) {
    const float at = x[i] + strength * folds[i];
    // A triangle wave, 1 in the middle of a vein and 0 between two, raised so that veins are thin.
    const float wave = std::fabs(2 * (at - std::floor(at)) - 1);
    const float sharp = wave * wave * wave;
    // Veins closer than two footprints fade into their mean: the integral of x^3 over [0, 1].
    const float shown = std::clamp(2 - 2 * footprint[i], 0.0f, 1.0f);
    const float share = sharp * shown + 0.25f * (1 - shown);
    Vec3f& albedo = places.surface[i]->albedo;
    albedo = albedo * (1 - share) + vein * share;
  }
}

}  // namespace tessera::core
