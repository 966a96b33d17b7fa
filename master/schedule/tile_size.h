// How large the tiles of the next frame are, where the person left it open. Pure.
//
// A tile costs a fixed time besides its pixels (messages, queues, the setting up of bundles), so
// many tiles are waste; and at a frame's end every render thread waits for the last one on average
// half a tile's time, so large ones are waste, too. With w seconds of work per thread and frame, o
// seconds of fixed cost per tile, tiles of t seconds lose o * w / t + t / 2, which is least at t =
// sqrt(2 * o * w). The master answers one tile after the other: n tiles that take it longer than w
// lose the difference. The cost of a pixel is what the last frames measured.
//
// Pictures do not depend on it.
//
// Threads. One owner.
#pragma once

#include <cstdint>

namespace tessera::master {

class TileSize {
 public:
  // Render time of `pixels` pixels on one thread.
  void measured(std::uint64_t pixels, double render_seconds);

  // Edge in pixels for a frame of this size on so many threads; kTileEdgeAutoPx before anything is
  // known. Keeps its last answer while that costs hardly more.
  int edge_px(int width_px, int height_px, std::uint32_t threads);

 private:
  double pixel_seconds_ = 0;
  int edge_px_ = 0;  // last answer
};

}  // namespace tessera::master
