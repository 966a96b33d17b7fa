// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/glossy_light.h"

#include <algorithm>

#include "slave/core/sampling/dimension.h"

namespace tessera::core {

std::uint64_t GlossyLight::add(const SurfaceBatch& batch, Vec3f* radiance) {
  std::uint64_t traced = 0;
  const auto samples = static_cast<std::uint32_t>(context_.settings.light_samples);
  for (std::uint32_t j = 0; j < samples; ++j) {
    if (context_.is_over()) break;
    rays_.clear();
    for (int i = 0; i < batch.count; ++i) {
      if (scattering_of(batch.surface[i].bsdf) != Scattering::kLobes) continue;
      rays_.ask(i, batch.key[i]);
    }
    rays_.scatter(batch, dimension(Dimension::kGlossy), batch.sample_index * samples + j);
    trace(radiance);
    traced += static_cast<std::uint64_t>(rays_.count());
  }
  return traced;
}

void GlossyLight::trace(Vec3f* radiance) {
  const float each = 1 / static_cast<float>(context_.settings.light_samples);
  Surface met_by[kPacketRays];
  Surface* to[kPacketRays];
  for (int i = 0; i < kPacketRays; ++i) to[i] = &met_by[i];
  rays_.trace_all();
  for (int first = 0; first < rays_.count(); first += kPacketRays) {
    const int n = std::min(kPacketRays, rays_.count() - first);
    const std::uint64_t met = rays_.take(first, n);
    rays_.meet(met, to, nullptr);
    rays_.look_at_sky(bits_below(n) & ~met);
    for (int i = 0; i < n; ++i) {
      Vec3f light;
      if ((met >> i & 1u) == 0) {
        light = rays_.sky_met(i);
      } else if (!is_black(met_by[i].emission)) {
        light = rays_.emission_met(i, met_by[i], context_.scene.lights.is_shared_out());
      }
      Vec3f& sum = radiance[rays_.pixel(first + i)];
      sum = sum + light * each;
    }
  }
}

}  // namespace tessera::core
