// SPDX-License-Identifier: Apache-2.0
// The planes of a tile besides its colour. The camera rays of its pixels are traced once more,
// whatever the renderer is, and the planes hold what they meet first. These rays are the renderer's
// own, to the bit, so alpha is the share of samples whose colour is not the background's. A
// renderer knows nothing of planes, and a frame without any pays nothing. A pixel depends on the
// same values as one of TileRenderer.
//
// Threads. One object per thread; memory, taken at the first tile.
#pragma once

#include <atomic>
#include <memory>
#include <span>

#include "common/base/isa.h"
#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "common/frame/tile_grid.h"
#include "slave/core/scene/prepared_scene.h"

namespace tessera::core {

class PlaneTile {
 public:
  PlaneTile();
  ~PlaneTile();

  // Writes the planes of the settings, one behind the other by rising number, each row by row.
  // Shape: to [rect.pixel_count() * channel_count(settings.planes)]. Requires: as
  // TileRenderer::render(). Returns: rays traced. When *is_cancelled turns true it returns early
  // and `to` is to be thrown away.
  RayCounts render(const PreparedScene& scene, const FrameSettings& settings, Isa isa,
                   const TileRect& rect, std::span<float> to,
                   const std::atomic<bool>* is_cancelled = nullptr);

 private:
  class Work;
  struct Memory;
  std::unique_ptr<Memory> memory_;
};

}  // namespace tessera::core
