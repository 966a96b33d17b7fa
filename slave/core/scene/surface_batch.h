// SPDX-License-Identifier: Apache-2.0
// Surfaces that are shaded together: what the primary rays of some pixels have hit, and what paths
// meet after them.
//
// Threads. Plain values of one worker.
#pragma once

#include <cstdint>
#include <memory>

#include "slave/core/surface/surface.h"
#include "slave/core/surface/surface_lobes.h"
#include "slave/core/trace/ray_groups.h"

namespace tessera::core {

inline constexpr int kBatchMax = RayGroups::kRaysMax;

// Pixels without a surface are left out; a pixel is in the batch once.
struct SurfaceBatch {
  int count = 0;
  Surface surface[kBatchMax];
  std::uint16_t pixel[kBatchMax];  // index of radiance
  std::uint32_t key[kBatchMax];    // pixel_key() of the pixel's first dimension
  std::uint32_t sample_index = 0;  // of the pixels' samples, counts from 0
  // Shape: [kBatchMax]; null in scenes without optional lobes. A surface's are at Surface::lobes.
  std::unique_ptr<SurfaceLobes[]> lobes;

  // Must be called before the first surface of a scene that has optional lobes.
  void make_room_for_lobes(bool has_lobes) {
    if (has_lobes && lobes == nullptr) lobes = std::make_unique<SurfaceLobes[]>(kBatchMax);
  }
  // Null where the surface has none.
  const SurfaceLobes* lobes_of(const Surface& s) const {
    return s.lobes == kNoLobes ? nullptr : &lobes[s.lobes];
  }
  // Requires: count < kBatchMax.
  void add(const SurfaceBatch& from, int i) {
    surface[count] = from.surface[i];
    pixel[count] = from.pixel[i];
    key[count] = from.key[i];
    if (surface[count].lobes != kNoLobes) {
      lobes[static_cast<std::size_t>(count)] = from.lobes[surface[count].lobes];
      surface[count].lobes = static_cast<std::uint16_t>(count);
    }
    ++count;
  }
};

}  // namespace tessera::core
