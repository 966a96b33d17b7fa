// SPDX-License-Identifier: Apache-2.0
// Renders one tile of one frame. A pixel depends on (settings, scene, isa, pixel, sample index) and
// nothing else: not on the tile it stands in, on threads or on order.
#pragma once

#include <atomic>
#include <memory>
#include <span>

#include "common/base/isa.h"
#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "common/frame/tile_grid.h"
#include "slave/core/integrate/frame_light.h"
#include "slave/core/ray/met_builds.h"
#include "slave/core/scene/prepared_scene.h"

namespace tessera::core {

// Instruction sets that this CPU and build have; kScalar always is.
IsaMask supported_isas();

// Scratch memory of one worker thread; used by one thread at a time, reused for every tile.
class TileRenderer {
 public:
  TileRenderer();
  ~TileRenderer();

  // Writes linear radiance, row by row from the tile's top left. Shape: rgb [3 *
  // rect.pixel_count()]. Requires: valid settings, rect inside the frame, isa in supported_isas().
  // frame_light: what tiles of the same frame share; without it each tile makes its own. Returns:
  // rays traced. When *is_cancelled turns true, or rays met what cannot be had (MetBuilds), it
  // returns early and rgb is to be thrown away.
  RayCounts render(const PreparedScene& scene, const FrameSettings& settings, Isa isa,
                   const TileRect& rect, std::span<float> rgb,
                   const std::atomic<bool>* is_cancelled = nullptr,
                   FrameLight* frame_light = nullptr);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace tessera::core
