// SPDX-License-Identifier: Apache-2.0
// How large the tiles of the next frame are, where the person left it open. Pure.
//
// A tile costs a fixed time besides its pixels (messages, queues, the setting up of bundles) and,
// where its pixels take light from their neighbours, a border, so many tiles are waste. At a
// frame's end render threads wait for its last tiles, of which the dearest take three times the
// mean, so large tiles are waste, too. With w seconds of work on pixels and borders per thread and
// frame, o seconds of fixed cost per tile, m of it on the master, which answers one tile after the
// other, a frame of n tiles of t seconds each by k threads takes
// max(w + o * n / k, n * m) + (1 - 1 / k) * 3 * t (tests/sim/README.md: measured for 200 to 700
// threads): a thread by itself waits for nobody. The cost of a pixel is what the last frames
// measured.
//
// Pictures do not depend on the size of their tiles.
//
// Threads. One owner.
#pragma once

#include <cstdint>

#include "common/base/limits.h"

namespace tessera::master {

class TileSize {
 public:
  // The tiles that a frame was rendered in.
  struct Tiles {
    int edge_px = kTileEdgeAutoPx;
    int border_px = 0;  // tile_border_px()
  };

  // A frame of `pixels` pixels took `render_seconds` of render threads in all.
  void measured(std::uint64_t pixels, double render_seconds, const Tiles& tiles);

  // Edge in pixels for a frame of this size on so many threads, its tiles with such a border;
  // kTileEdgeAutoPx before anything is known. The last answer is kept while it costs hardly more.
  int edge_px(int width_px, int height_px, std::uint32_t threads, int border_px);

 private:
  double pixel_seconds_ = 0;  // without borders
  int edge_px_ = 0;           // last answer
};

}  // namespace tessera::master
