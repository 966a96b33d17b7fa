// SPDX-License-Identifier: Apache-2.0
#include "common/frame/tile_grid.h"

#include <gtest/gtest.h>

#include <vector>

namespace tessera {
namespace {

TEST(TileGrid, EveryPixelLiesInExactlyOneTile) {
  for (const auto [width, height, edge] :
       {std::array{150, 101, 16}, {1, 1, 32}, {64, 64, 32}, {33, 7, 4}, {5, 300, 256}}) {
    const TileGrid grid(width, height, edge);
    std::vector<int> covered(static_cast<std::size_t>(width * height));
    for (TileIndex tile = 0; tile < grid.tile_count(); ++tile) {
      const TileRect r = grid.rect(tile);
      ASSERT_GE(r.width_px, 1);
      ASSERT_LE(r.width_px, edge);
      ASSERT_GE(r.height_px, 1);
      for (int y = r.y_px; y < r.y_px + r.height_px; ++y) {
        for (int x = r.x_px; x < r.x_px + r.width_px; ++x) {
          ++covered.at(static_cast<std::size_t>(y * width + x));
        }
      }
    }
    EXPECT_EQ(covered, std::vector<int>(covered.size(), 1))
        << width << "x" << height << ", tiles of " << edge;
  }
}

}  // namespace
}  // namespace tessera
