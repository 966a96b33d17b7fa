#include "slave/core/render/open_sky.h"

#include <cstring>

namespace tessera::core {

static_assert(kSkyPoints == kPacketRays);

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

}  // namespace tessera::core
