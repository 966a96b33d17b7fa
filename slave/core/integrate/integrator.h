// SPDX-License-Identifier: Apache-2.0
// A renderer, as TileRenderer sees it: something that makes the pixels of a tile. Each is a folder
// beside this file and a row in integrators.cpp.
//
// Threads. One object per thread; it keeps its scratch memory from tile to tile.
#pragma once

#include <memory>
#include <span>

#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "common/frame/tile_grid.h"
#include "slave/core/integrate/render_context.h"

namespace tessera::core {

class Integrator {
 public:
  Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;
  virtual ~Integrator() = default;

  // Renders a tile as TileRenderer::render() does. Requires: the context's settings ask for this
  // renderer.
  virtual RayCounts render(const RenderContext& context, const TileRect& rect,
                           std::span<float> rgb) = 0;
};

struct IntegratorRow {
  Renderer renderer;
  std::unique_ptr<Integrator> (*make)();
};
// Every renderer has one row.
std::span<const IntegratorRow> integrators();

}  // namespace tessera::core
