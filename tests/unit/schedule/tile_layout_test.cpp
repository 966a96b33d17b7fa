// SPDX-License-Identifier: Apache-2.0
// The order and the size of tiles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>

#include "common/base/limits.h"
#include "master/schedule/tile_order.h"
#include "master/schedule/tile_size.h"

namespace tessera::master {
namespace {

TEST(TileOrder, EveryTileOfAnyGridComesOnce) {
  for (int columns : {1, 2, 7, 8, 9, 20, 33}) {
    for (int rows : {1, 3, 8, 15, 17}) {
      const std::vector<TileIndex> order = tile_order(columns, rows);
      const std::set<TileIndex> all(order.begin(), order.end());
      EXPECT_EQ(order.size(), static_cast<std::size_t>(columns * rows));
      EXPECT_EQ(all.size(), order.size());
      EXPECT_EQ(*all.rbegin(), static_cast<TileIndex>(columns * rows - 1));
    }
  }
}

TEST(TileOrder, OneTileIsBesideTheNext) {
  constexpr int kColumns = 24, kRows = 16;  // whole blocks: the curve has no jump
  const std::vector<TileIndex> order = tile_order(kColumns, kRows);
  int jumps = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const int from = static_cast<int>(order[i - 1]), to = static_cast<int>(order[i]);
    jumps +=
        std::abs(from % kColumns - to % kColumns) + std::abs(from / kColumns - to / kColumns) != 1;
  }
  EXPECT_LE(jumps, 1) << "one from band to band: a band ends at its top";
}

TEST(TileOrder, ABandIsWholeBeforeTheNextOneBegins) {
  const std::vector<TileIndex> order = tile_order(20, 24);
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i] / 20 / 8, i / (20 * 8));
}

TEST(TileSize, IsTheDefaultBeforeAnythingIsKnown) {
  EXPECT_EQ(TileSize().edge_px(640, 480, 8, 0), kTileEdgeAutoPx);
}

int edge_at(double pixel_seconds, int width, int height, std::uint32_t threads, int border_px = 0) {
  TileSize size;
  size.measured(1000, 1000 * pixel_seconds, {});
  return size.edge_px(width, height, threads, border_px);
}

TEST(TileSize, DearPixelsAndManyThreadsMakeSmallTilesCheapOnesLarge) {
  EXPECT_EQ(edge_at(1e-4, 640, 480, 8), 16);
  EXPECT_EQ(edge_at(2e-8, 1920, 1080, 2), 128);
  EXPECT_LT(edge_at(1e-6, 640, 480, 50), edge_at(1e-6, 640, 480, 2));
  EXPECT_LE(edge_at(1e-6, 320, 240, 8), edge_at(1e-6, 7680, 4320, 8));
}

// tests/sim found that tiles of 16 pixels for 700 slaves drowned the master, one thread of which
// answers all tiles, at a third of the speed of 500 slaves.
TEST(TileSize, ManySlavesDoNotDrownTheMasterAndAreNotLeftWithoutTiles) {
  constexpr double kMasterTileSeconds = 18e-6;
  for (const double pixel_seconds : {1.4e-6, 6.3e-6}) {
    for (const std::uint32_t threads : {200u, 300u, 500u, 700u, 1000u}) {
      const int edge = edge_at(pixel_seconds, 3840, 2160, threads);
      const double work = 3840.0 * 2160 * pixel_seconds / threads;
      const double tiles = std::ceil(3840.0 / edge) * std::ceil(2160.0 / edge);
      EXPECT_LE(kMasterTileSeconds * tiles, std::max(1.3 * work, 0.04)) << threads << ", " << edge;
      EXPECT_GE(2 * tiles, threads) << "two frames in flight; " << threads << ", " << edge;
    }
  }
  for (const std::uint32_t threads : {300u, 500u, 700u})  // 96 has two thirds of the speed
    EXPECT_EQ(edge_at(1.4e-6, 3840, 2160, threads), 64) << threads;
}

// Neighbours' light is rendered again for each tile that takes it, so a border asks for larger
// tiles, and what it cost in the last frame is not what pixels cost.
TEST(TileSize, BordersMakeTilesLarger) {
  EXPECT_EQ(edge_at(1e-5, 320, 240, 4), 16);
  EXPECT_EQ(edge_at(1e-5, 320, 240, 4, 2), 32);
  TileSize size;
  size.measured(1000, 1000 * 1e-5 * 1.5625, {16, 2});  // 20 x 20 pixels for 16 x 16
  EXPECT_EQ(size.edge_px(320, 240, 4, 0), 16);
  EXPECT_EQ(size.edge_px(320, 240, 4, 2), 32);
}

// A thread by itself waits for no other's last tile, but a tile is to be seen, and to be had again,
// within a quarter of a second.
TEST(TileSize, OneThreadHasTheLargestTilesThatAreSeenSoon) {
  EXPECT_EQ(edge_at(1e-6, 640, 480, 1), 128);
  EXPECT_EQ(edge_at(4e-5, 640, 480, 1), 64);
  EXPECT_EQ(edge_at(1e-3, 640, 480, 1), 16);
  TileSize size;
  size.measured(1000, 1000 * 1e-6, {});
  EXPECT_EQ(size.edge_px(640, 480, 1, 0), 128);
  for (int i = 0; i < 20; ++i) size.measured(1000, 1000 * 4e-5, {});
  EXPECT_EQ(size.edge_px(640, 480, 1, 0), 64);
}

TEST(TileSize, SmallChangesKeepTheSize) {
  TileSize size;
  size.measured(1000, 1000 * 1e-6, {});
  const int edge = size.edge_px(1280, 720, 8, 0);
  for (int i = 0; i < 100; ++i) {
    size.measured(1000, 1000 * (i % 2 == 0 ? 0.8e-6 : 1.25e-6), {});
    EXPECT_EQ(size.edge_px(1280, 720, 8, 0), edge);
  }
}

TEST(TileSize, NonsenseIsIgnored) {
  TileSize size;
  size.measured(0, 1, {});
  size.measured(10, -1, {});
  size.measured(10, std::numeric_limits<double>::quiet_NaN(), {});
  EXPECT_EQ(size.edge_px(640, 480, 8, 0), kTileEdgeAutoPx);
}

}  // namespace
}  // namespace tessera::master
