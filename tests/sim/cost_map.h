// SPDX-License-Identifier: Apache-2.0
// What tiles cost, as the product recorded it: the render time of every tile of a few frames on one
// thread (costs/*.csv, written by record_costs.py from a --trace). A tile of another size, in a
// frame of another size, costs what the pixels of its place cost there.
//
// Threads. A plain value.
//
// Layout. seconds_[(frame * rows + row) * columns + column]: seconds for one pixel of that tile.
#pragma once

#include <string>
#include <vector>

#include "common/base/ids.h"
#include "common/base/status.h"
#include "common/frame/tile_grid.h"

namespace tessera::sim {

class CostMap {
 public:
  // Returns: the map, or what is wrong with the file.
  static Result<CostMap> read(const std::string& path);
  static Result<CostMap> parse(const std::string& text, const std::string& path);

  // Returns: seconds of one thread for the tile. Frames beyond those recorded go back and forth, as
  // a camera does that keeps moving. Requires: `rect` lies in a frame of that size.
  double tile_seconds(FrameId frame, const TileRect& rect, int width_px, int height_px) const;
  double frame_seconds(FrameId frame) const;  // of the frame as it was recorded
  int frame_count() const { return frame_count_; }

 private:
  const double* row_of(FrameId frame, int row) const;

  TileGrid grid_{1, 1, 1};
  int width_px_ = 0, height_px_ = 0, edge_px_ = 0, frame_count_ = 0;
  std::vector<double> seconds_;
};

}  // namespace tessera::sim
