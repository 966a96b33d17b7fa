// Marble: sheets of vein through the stone, `frequency` of them a unit along x, folded by
// turbulence (after Perlin, "An image synthesizer", 1985). The material's albedo is the stone.
#include <algorithm>
#include <cmath>

#include "slave/core/surface/noise.h"
#include "slave/core/surface/programs.h"

namespace tessera::core {

void apply_marble(const SurfaceParameters& parameters, const SurfacePlace& place, Surface& s) {
  const float frequency = parameters[0], strength = parameters[1];
  const Vec3f vein{parameters[2], parameters[3], parameters[4]};
  const Vec3f p = place.point * frequency;
  const float footprint = place.footprint * frequency;
  const float at = p.x + strength * turbulence(p, 0x6d617262u, footprint);
  // A triangle wave, 1 in the middle of a vein and 0 between two, raised so that veins are thin.
  const float wave = std::fabs(2 * (at - std::floor(at)) - 1);
  const float sharp = wave * wave * wave;
  // Veins closer than two footprints are their mean: the integral of x^3 over [0, 1].
  const float shown = std::clamp(2 - 2 * footprint, 0.0f, 1.0f);
  const float share = sharp * shown + 0.25f * (1 - shown);
  s.albedo = s.albedo * (1 - share) + vein * share;
}

}  // namespace tessera::core
