// SPDX-License-Identifier: Apache-2.0
// Wood: year rings about the y axis, `frequency` of them a unit, out of round by `wobble` rings,
// with grain along y. The material's albedo is the early, light part of a ring.
#include <algorithm>
#include <cmath>

#include "slave/core/surface/programs.h"

namespace tessera::core {

void apply_wood(const SurfaceParameters& parameters, const Noise& noise,
                const SurfacePlaces& places) {
  const float frequency = parameters[0], wobble = parameters[1], grain = parameters[2];
  const Vec3f dark{parameters[3], parameters[4], parameters[5]};
  const std::size_t count = places.surface.size();
  std::array<float, kPlacesMax> x, y, z, out_of_round, fibre;
  const NoiseArgument at{{x.data(), count}, {y.data(), count}, {z.data(), count}};
  const auto stretch = [&](float across, float along) {
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = places.point[0][i] * frequency * across;
      y[i] = places.point[1][i] * frequency * along;
      z[i] = places.point[2][i] * frequency * across;
    }
  };
  stretch(0.25f, 0.06f);  // trunks bend slowly along their axis
  noise.gradient(at, 0x776f6f64u, {out_of_round.data(), count});
  stretch(12, 0.6f);
  noise.gradient(at, 0x66696265u, {fibre.data(), count});
  stretch(1, 1);
  for (std::size_t i = 0; i < count; ++i) {
    const float footprint = places.footprint[i] * frequency;
    const float radius = std::sqrt(x[i] * x[i] + z[i] * z[i]) + wobble * 2 * out_of_round[i];
    const float ring = radius - std::floor(radius);
    // A ring darkens slowly and ends at once; the end is as wide as the footprint, so that it has
    // no steps.
    const float end = std::max(0.1f, std::min(footprint, 0.5f));
    const float late = ring < 1 - end ? ring / (1 - end) : (1 - ring) / end;
    const float shown = std::clamp(2 - 2 * footprint, 0.0f, 1.0f);
    const float fibre_shown = std::clamp(2 - 24 * footprint, 0.0f, 1.0f);
    const float streak = fibre_shown > 0 ? grain * fibre_shown * fibre[i] : 0.0f;
    const float share = std::clamp(
        (late * late * shown + (1 - shown) / 3) * (1 + streak) + 0.3f * streak, 0.0f, 1.0f);
    Vec3f& albedo = places.surface[i]->albedo;
    albedo = albedo * (1 - share) + dark * share;
  }
}

}  // namespace tessera::core
