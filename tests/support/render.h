// SPDX-License-Identifier: Apache-2.0
// A picture rendered as one tile or as many, for tests of what its pixels are.
// Threads. Pure functions.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <vector>

#include "slave/core/integrate/tile_renderer.h"

namespace tessera::test {

// Renders one tile with the widest instruction set here. Shape: [3 * width * height], row by row.
inline std::vector<float> render(const Scene& scene, const FrameSettings& settings) {
  const auto prepared = core::PreparedScene::build(scene, {});
  EXPECT_TRUE(prepared.is_ok());
  std::vector<float> rgb(3 * static_cast<std::size_t>(settings.width_px * settings.height_px));
  core::TileRenderer renderer;
  renderer.render(**prepared, settings, widest_isa(core::supported_isas()),
                  {0, 0, settings.width_px, settings.height_px}, rgb);
  return rgb;
}

// Renders a picture in tiles of edge_px, the last one first, since their order must not matter.
inline std::vector<float> render_in_tiles(const core::PreparedScene& scene,
                                          const FrameSettings& settings, Isa isa, int edge_px,
                                          RayCounts* counts = nullptr) {
  const auto width = static_cast<std::size_t>(settings.width_px);
  std::vector<float> image(3 * width * static_cast<std::size_t>(settings.height_px), -1.0f);
  core::TileRenderer renderer;
  const TileGrid grid(settings.width_px, settings.height_px, edge_px);
  for (TileIndex i = grid.tile_count(); i-- > 0;) {
    const TileRect rect = grid.rect(i);
    std::vector<float> rgb(3 * static_cast<std::size_t>(rect.pixel_count()));
    const RayCounts rays = renderer.render(scene, settings, isa, rect, rgb);
    if (counts != nullptr) *counts += rays;
    const auto row_floats = 3 * static_cast<std::size_t>(rect.width_px);
    for (std::size_t y = 0; y < static_cast<std::size_t>(rect.height_px); ++y) {
      const std::size_t at = 3 * ((static_cast<std::size_t>(rect.y_px) + y) * width +
                                  static_cast<std::size_t>(rect.x_px));
      std::copy_n(rgb.begin() + static_cast<std::ptrdiff_t>(y * row_floats), row_floats,
                  image.begin() + static_cast<std::ptrdiff_t>(at));
    }
  }
  return image;
}

inline bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float x, float y) {
    return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y);
  });
}

}  // namespace tessera::test
