// SPDX-License-Identifier: Apache-2.0
// Pixels around a tile that are rendered with it, since the tile's pixels take light from them.
//
// Threads. Pure function.
#pragma once

#include <cstdint>

#include "common/frame/frame_settings.h"

namespace tessera {

// igi: number of passes that are filtered. In a picture of few passes the filter removes noise; the
// mean of many passes has little noise by itself, and without the filter each pixel keeps its own
// value.
inline constexpr std::uint32_t kFilteredPasses = 16;

// Larger tiles are rendered in blocks of this edge, each with its border.
inline constexpr int kBorderBlockPx = 64;

// Width of the border on each side.
inline int tile_border_px(const FrameSettings& settings) {
  const bool is_filtered = settings.renderer == Renderer::kIgi && settings.is_filtered &&
                           settings.pass < kFilteredPasses;
  return is_filtered ? settings.interleave / 2 : 0;
}

}  // namespace tessera
