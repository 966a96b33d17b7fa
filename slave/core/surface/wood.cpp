// Wood: year rings about the y axis, `frequency` of them a unit, out of round by `wobble` rings, with
// grain along y. The material's albedo is the early, light part of a ring.
#include <algorithm>
#include <cmath>

#include "slave/core/surface/noise.h"
#include "slave/core/surface/programs.h"

namespace tessera::core {

void apply_wood(const SurfaceParameters& parameters, const SurfacePlace& place, Surface& s) {
  const float frequency = parameters[0], wobble = parameters[1], grain = parameters[2];
  const Vec3f dark{parameters[3], parameters[4], parameters[5]};
  const Vec3f p = place.point * frequency;
  const float footprint = place.footprint * frequency;
  const Vec3f slow{p.x * 0.25f, p.y * 0.06f, p.z * 0.25f};  // trunks bend slowly along their axis
  const float radius =
      std::sqrt(p.x * p.x + p.z * p.z) + wobble * 2 * gradient_noise(slow, 0x776f6f64u);
  const float ring = radius - std::floor(radius);
  // A ring darkens slowly and ends at once; the end is as wide as the footprint, so that it has no
  // steps.
  const float end = std::max(0.1f, std::min(footprint, 0.5f));
  const float late = ring < 1 - end ? ring / (1 - end) : (1 - ring) / end;
  const float shown = std::clamp(2 - 2 * footprint, 0.0f, 1.0f);
  const Vec3f fibre{p.x * 12, p.y * 0.6f, p.z * 12};
  const float fibre_shown = std::clamp(2 - 24 * footprint, 0.0f, 1.0f);
  const float streak =
      fibre_shown > 0 ? grain * fibre_shown * gradient_noise(fibre, 0x66696265u) : 0.0f;
  const float share = std::clamp(
      (late * late * shown + (1 - shown) / 3) * (1 + streak) + 0.3f * streak, 0.0f, 1.0f);
  s.albedo = s.albedo * (1 - share) + dark * share;
}

}  // namespace tessera::core
