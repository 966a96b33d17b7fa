// SPDX-License-Identifier: Apache-2.0
// Recorded costs: nothing is lost when tiles are cut otherwise, and a broken file is refused.
#include "tests/sim/cost_map.h"

#include <gtest/gtest.h>

namespace tessera::sim {
namespace {

// Two frames of 100 x 60 pixels in tiles of 32: four columns (the last is 4 wide), two rows.
constexpr const char* kText =
    "# a comment\n100,60,32,2\n"
    "100,200,300,40\n500,600,700,80\n"
    "1,1,1,1\n1,1,1,1\n";

CostMap map_of(const std::string& text) {
  Result<CostMap> map = CostMap::parse(text, "here");
  EXPECT_TRUE(map.is_ok()) << map.status().message();
  return *map;
}

double sum(const CostMap& map, const TileGrid& grid, int width, int height) {
  double seconds = 0;
  for (TileIndex tile = 0; tile < grid.tile_count(); ++tile)
    seconds += map.tile_seconds(0, grid.rect(tile), width, height);
  return seconds;
}

TEST(CostMap, ATileAsRecordedCostsWhatWasRecorded) {
  const CostMap map = map_of(kText);
  const TileGrid grid(100, 60, 32);
  const double expected[] = {100, 200, 300, 40, 500, 600, 700, 80};
  for (TileIndex tile = 0; tile < 8; ++tile)
    EXPECT_NEAR(map.tile_seconds(0, grid.rect(tile), 100, 60), 1e-6 * expected[tile], 1e-12);
}

TEST(CostMap, OtherTilesHaveTheSameSum) {
  const CostMap map = map_of(kText);
  EXPECT_NEAR(map.frame_seconds(0), 2520e-6, 1e-12);
  for (const int edge : {4, 16, 48, 64, 128})
    EXPECT_NEAR(sum(map, TileGrid(100, 60, edge), 100, 60), 2520e-6, 1e-12) << edge;
}

TEST(CostMap, CostsGrowWithThePixels) {
  const CostMap map = map_of(kText);
  EXPECT_NEAR(sum(map, TileGrid(300, 180, 32), 300, 180), 9 * 2520e-6, 1e-11);
  EXPECT_NEAR(sum(map, TileGrid(100, 120, 32), 100, 120), 2 * 2520e-6, 1e-11);
}

TEST(CostMap, FramesGoForthAndBack) {
  const CostMap map = map_of("4,4,4,3\n1\n2\n3\n");
  for (const auto& [frame, cost] :
       {std::pair(0, 1), {1, 2}, {2, 3}, {3, 2}, {4, 1}, {5, 2}, {400, 1}})
    EXPECT_NEAR(map.frame_seconds(static_cast<FrameId>(frame)), 1e-6 * cost, 1e-12) << frame;
}

TEST(CostMap, WhatIsBrokenIsRefusedWithItsName) {
  for (const char* text :
       {"", "100,60,32", "100,60,0,1\n", "100,60,32,1\n1,2,3\n", "4,4,4,1\n-1\n", "4,4,4,1\nnan\n",
        "4,4,4,1\n1e\n", "4,4,4,1\n1,2\n", "4.5,4,4,1\n1\n", "4,4,4,1\nx\n"}) {
    const Result<CostMap> map = CostMap::parse(text, "here.csv");
    ASSERT_FALSE(map.is_ok()) << text;
    EXPECT_NE(map.status().message().find("here.csv"), std::string::npos);
  }
  EXPECT_FALSE(CostMap::read("/nowhere/at/all.csv").is_ok());
}

}  // namespace
}  // namespace tessera::sim
