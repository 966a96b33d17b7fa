// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/tile_size.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/limits.h"

namespace tessera::master {
namespace {

// Edges that hold whole bundles of 8 x 8 rays and whole blocks of bundles. None is below 16, where
// a tile's message weighs as much as its pixels, or above 128, whose float pixels are 192 KiB.
constexpr std::array<int, 6> kEdges{16, 32, 48, 64, 96, 128};
// Fixed cost of a tile on slave and master, an estimate (the master's part is 10 to 15 us by
// tests/bench exchange). The loss is flat about its least: twice the cost moves the edge by one
// step at most.
constexpr double kTileOverheadSeconds = 60e-6;
// The part of it on the master's one thread, by `tessera-bench exchange` with 64 connections and
// TLS.
constexpr double kMasterTileSeconds = 18e-6;
// The dearest tile of a frame takes three times the mean (tests/sim/costs), and may begin last.
constexpr double kTailTiles = 3;
// Weight of the newest measurement, which is one whole frame.
constexpr double kWeight = 0.3;
// Another size is taken only when tiling then costs less than this share of the present cost.
constexpr double kGain = 0.8;

}  // namespace

void TileSize::measured(std::uint64_t pixels, double render_seconds) {
  if (pixels == 0 || !(render_seconds > 0)) return;
  const double cost = render_seconds / static_cast<double>(pixels);
  pixel_seconds_ += (pixel_seconds_ == 0 ? 1 : kWeight) * (cost - pixel_seconds_);
}

int TileSize::edge_px(int width_px, int height_px, std::uint32_t threads) {
  if (pixel_seconds_ == 0) return kTileEdgeAutoPx;
  const double pixels = static_cast<double>(width_px) * height_px;
  const double work = pixels * pixel_seconds_ / std::max(threads, 1u);
  const auto loss = [&](int edge) {
    // A tile larger than the frame is as large as the frame.
    const double tile =
        static_cast<double>(std::min(edge, width_px)) * std::min(edge, height_px) * pixel_seconds_;
    const double tiles = std::ceil(static_cast<double>(width_px) / edge) *
                         std::ceil(static_cast<double>(height_px) / edge);
    const double slaves = work + kTileOverheadSeconds * work / tile;
    return std::max(slaves, tiles * kMasterTileSeconds) + kTailTiles * tile - work;
  };
  const int best = *std::min_element(kEdges.begin(), kEdges.end(),
                                     [&](int a, int b) { return loss(a) < loss(b); });
  if (edge_px_ == 0 || loss(best) < kGain * loss(edge_px_)) edge_px_ = best;
  return edge_px_;
}

}  // namespace tessera::master
