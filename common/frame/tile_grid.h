// SPDX-License-Identifier: Apache-2.0
// How a frame is cut into square tiles: row by row from the top left; border tiles are smaller.
// Threads. Plain values. Invariant: every pixel lies in exactly one tile; master and slave compute
// the same grid from (width, height, edge), so that only tile numbers travel.
#pragma once

#include "common/base/check.h"
#include "common/base/ids.h"

namespace tessera {

struct TileRect {
  int x_px = 0, y_px = 0;           // top left corner
  int width_px = 0, height_px = 0;  // at least 1 each
  int pixel_count() const { return width_px * height_px; }
  bool operator==(const TileRect&) const = default;
};

class TileGrid {
 public:
  // Requires: all at least 1.
  TileGrid(int width_px, int height_px, int tile_edge_px)
      : width_px_(width_px),
        height_px_(height_px),
        edge_px_(tile_edge_px),
        columns_((width_px + tile_edge_px - 1) / tile_edge_px),
        rows_((height_px + tile_edge_px - 1) / tile_edge_px) {}

  TileIndex tile_count() const {
    return static_cast<TileIndex>(columns_) * static_cast<TileIndex>(rows_);
  }

  int columns() const { return columns_; }
  int rows() const { return rows_; }

  // Requires: index < tile_count().
  TileRect rect(TileIndex index) const {
    TESSERA_CHECK_LT(index, tile_count());
    const int column = static_cast<int>(index) % columns_;
    const int row = static_cast<int>(index) / columns_;
    TileRect r{column * edge_px_, row * edge_px_, edge_px_, edge_px_};
    if (r.x_px + r.width_px > width_px_) r.width_px = width_px_ - r.x_px;
    if (r.y_px + r.height_px > height_px_) r.height_px = height_px_ - r.y_px;
    return r;
  }

 private:
  int width_px_, height_px_, edge_px_, columns_, rows_;
};

}  // namespace tessera
