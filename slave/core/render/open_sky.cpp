#include "slave/core/render/open_sky.h"

#include <cstring>

namespace tessera::core {

static_assert(kSkyPoints == kPacketRays && kSkyPoints == kSamplePoints);

void OpenSky::begin(const LightSet& lights, const KernelTable& kernels) {
  lights_ = &lights;
  kernels_ = &kernels;
  if (has_map()) view_ = lights.sky_map->view();
}

void OpenSky::look(const float (&direction)[3][kPacketRays], std::uint64_t rays) {
  if (!has_map() || rays == 0) return;
  std::memcpy(points_.direction, direction, sizeof(direction));
  points_.wanted = rays;
  kernels_->sky_light(view_, points_);
}

void OpenSky::sample(const SamplePoints& points) {
  std::memcpy(points_.square, points.square, sizeof(points.square));
  points_.wanted = ~std::uint64_t{0} >> (kSkyPoints - points.count);
  kernels_->sky_samples(view_, points_);
}

}  // namespace tessera::core
