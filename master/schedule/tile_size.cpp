// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/tile_size.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/limits.h"
#include "common/frame/tile_border.h"

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
// A tile is shown when it is done, and one that is lost with its slave begins anew, so none takes
// longer than this where a smaller one does not.
constexpr double kTileSecondsMax = 0.25;
// Weight of the newest measurement, which is one whole frame.
constexpr double kWeight = 0.3;
// Another size is taken only when tiling then costs less than this share of the present cost.
constexpr double kGain = 0.8;

// Pixels that are rendered for each pixel of a tile.
double rendered_per_pixel(const TileSize::Tiles& tiles) {
  const int block = std::clamp(tiles.edge_px, 1, kBorderBlockPx);
  const double per_axis = (block + 2.0 * tiles.border_px) / block;
  return per_axis * per_axis;
}

}  // namespace

void TileSize::measured(std::uint64_t pixels, double render_seconds, const Tiles& tiles) {
  if (pixels == 0 || !(render_seconds > 0)) return;
  const double cost = render_seconds / static_cast<double>(pixels) / rendered_per_pixel(tiles);
  pixel_seconds_ += (pixel_seconds_ == 0 ? 1 : kWeight) * (cost - pixel_seconds_);
}

int TileSize::edge_px(int width_px, int height_px, std::uint32_t threads, int border_px) {
  if (pixel_seconds_ == 0) return kTileEdgeAutoPx;
  const double pixels = static_cast<double>(width_px) * height_px;
  const double share = 1.0 / std::max(threads, 1u);  // of a thread
  // A tile larger than the frame is as large as the frame.
  const auto tile_seconds = [&](int edge) {
    return static_cast<double>(std::min(edge, width_px)) * std::min(edge, height_px) *
           pixel_seconds_ * rendered_per_pixel({edge, border_px});
  };
  const auto loss = [&](int edge) {
    const double tile = tile_seconds(edge);
    const double work = pixels * pixel_seconds_ * share * rendered_per_pixel({edge, border_px});
    const double tiles = std::ceil(static_cast<double>(width_px) / edge) *
                         std::ceil(static_cast<double>(height_px) / edge);
    const double slaves = work + kTileOverheadSeconds * work / tile;
    return std::max(slaves, tiles * kMasterTileSeconds) + (1 - share) * kTailTiles * tile -
           pixels * pixel_seconds_ * share;
  };
  const auto is_usable = [&](int edge) {
    return edge == kEdges.front() || tile_seconds(edge) <= kTileSecondsMax;
  };
  int best = kEdges.front();
  for (const int edge : kEdges) {
    if (is_usable(edge) && loss(edge) < loss(best)) best = edge;
  }
  if (edge_px_ == 0 || !is_usable(edge_px_) || loss(best) < kGain * loss(edge_px_)) edge_px_ = best;
  return edge_px_;
}

}  // namespace tessera::master
