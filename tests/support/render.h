// A picture rendered as one tile, for tests of what its pixels are.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "slave/core/render/tile_renderer.h"

namespace tessera::test {

// With the widest instruction set here. Shape: [3 * width * height], row by row.
inline std::vector<float> render(const Scene& scene, const FrameSettings& settings) {
  const auto prepared = core::PreparedScene::build(scene, {});
  EXPECT_TRUE(prepared.is_ok());
  std::vector<float> rgb(3 * static_cast<std::size_t>(settings.width_px * settings.height_px));
  core::TileRenderer renderer;
  renderer.render(**prepared, settings, widest_isa(core::supported_isas()),
                  {0, 0, settings.width_px, settings.height_px}, rgb);
  return rgb;
}

}  // namespace tessera::test
