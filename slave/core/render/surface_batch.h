// Surfaces that are shaded together: what the primary rays of some pixels have hit, and what paths
// meet after them.
//
// Threads. Plain values of one worker.
#pragma once

#include <cstdint>

#include "slave/core/surface/surface.h"
#include "slave/core/trace/ray_groups.h"

namespace tessera::core {

inline constexpr int kBatchMax = RayGroups::kRaysMax;

// Pixels without a surface are left out; a pixel is in it once.
struct SurfaceBatch {
  int count = 0;
  Surface surface[kBatchMax];
  std::uint16_t pixel[kBatchMax];  // index of radiance
  std::uint32_t key[kBatchMax];    // pixel_key() of the pixel's first dimension
  std::uint32_t sample_index = 0;  // of the pixels' samples, counts from 0
};

}  // namespace tessera::core
