// SPDX-License-Identifier: Apache-2.0
#include "slave/core/integrate/open_sky.h"

#include <algorithm>
#include <cstring>

#include "slave/core/ray/ray_bits.h"

namespace tessera::core {

static_assert(kSkyPoints == kPacketRays && kSkyPoints == kSamplePoints);

OpenSky::OpenSky(const LightSet& lights, const KernelTable& kernels, SkyPoints& memory)
    : lights_(lights),
      kernels_(kernels),
      view_(lights.sky_map != nullptr ? lights.sky_map->view() : SkyView{}),
      memory_(memory) {}

void OpenSky::look(const float (&direction)[3][kPacketRays], std::uint64_t rays) {
  if (!has_map() || rays == 0) return;
  std::memcpy(memory_.direction, direction, sizeof(direction));
  memory_.wanted = rays;
  kernels_.sky_light(view_, memory_);
}

void OpenSky::look_out(const float (&direction)[3][kPacketRays], std::uint64_t rays) {
  const Background& background = lights_.background;
  if (background.kind == BackgroundKind::kSky) return look(direction, rays);
  for_each_ray(rays, [&](int i) {
    const Vec3f d = normalize({direction[0][i], direction[1][i], direction[2][i]});
    const float up = std::clamp(0.5f + d.y, 0.0f, 1.0f);  // within 30 degrees of the horizon
    put_vector(background.low * (1 - up) + background.high * up, memory_.radiance, i);
  });
}

void OpenSky::sample(const SamplePoints& points) {
  std::memcpy(memory_.square, points.square, sizeof(points.square));
  memory_.wanted = ~std::uint64_t{0} >> (kSkyPoints - points.count);
  kernels_.sky_samples(view_, memory_);
}

}  // namespace tessera::core
