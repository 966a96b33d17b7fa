// SPDX-License-Identifier: Apache-2.0
// One frame on its way: its pixels as they come in, and what it costs. Pixels are written straight
// from a result's payload into the image; there is no second copy.
//
// The digest follows the colour, band of tiles by band, so that no single moment hashes a whole
// frame; planes, which lie behind the whole colour, are hashed at the end. A tile settles when no
// audit can put another slave's pixels in place of the first one's any more; the digest waits for
// that, since the hasher's thread must not read what is still written.
//
// Threads. Io thread only. Invariant. Each tile is written once (the ledger sees to it), except
// under audit.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>

#include "common/base/clock.h"
#include "common/frame/frame_image.h"
#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "common/frame/tile_grid.h"
#include "master/frame_loop/frame_digest.h"

namespace tessera::master {

class FrameAssembly {
 public:
  FrameAssembly(FrameId frame, SceneVersion version, const FrameSettings& settings,
                FrameDigest digest);

  // Memory that the frame takes in all: pixels, and what is kept for each tile.
  std::uint64_t needed_bytes() const;
  // Bytes of pixels: what allocate() took, 0 before it, and how many of them were written.
  std::uint64_t image_bytes() const { return image_->bytes.size(); }
  std::uint64_t written_bytes() const { return std::min(written_bytes_, image_bytes()); }

  // One line for a frame that does not fit into the master's memory.
  static std::string refusal(std::uint64_t needed_bytes, std::uint64_t free_bytes);

  // Takes memory for the pixels. Call before the first tile. Returns: kResourceExhausted.
  Status allocate();

  const FrameSettings& settings() const { return settings_; }
  const TileGrid& grid() const { return grid_; }
  FrameStats& stats() { return stats_; }
  SceneVersion version() const { return stats_.scene_version; }
  std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(settings_.width_px) *
           static_cast<std::uint64_t>(settings_.height_px);
  }

  const PixelLayout& layout() const { return layout_; }

  // Payload size that the tile must have.
  std::size_t tile_bytes(TileIndex tile) const;
  // The colour among a tile's pixels. This and write_tile() require: pixels.size() ==
  // tile_bytes(tile).
  std::span<std::byte> colour_of(TileIndex tile, std::span<std::byte> pixels) const;
  void write_tile(TileIndex tile, std::span<const std::byte> pixels, std::uint16_t slave_ordinal);
  // The tile is not written any more. Call at most once for each; tiles that were never settled
  // are with the last one.
  void settle_tile(TileIndex tile);

  // Takes the finished image. Call once.
  std::shared_ptr<const FrameImage> finish() { return std::move(image_); }
  // Takes the digest of all pixels. Requires: every tile was written.
  FrameDigest take_digest();

 private:
  void write_rows(const TileRect& rect, std::span<const std::byte> pixels, std::size_t before_bytes,
                  std::size_t bytes);
  std::size_t band_bytes() const;  // of colour, in a row of tiles
  void hash_whole_bands();

  const FrameSettings settings_;
  const PixelLayout layout_;
  const TileGrid grid_;
  FrameStats stats_;
  std::shared_ptr<FrameImage> image_;
  std::vector<int> band_missing_;  // [rows of tiles] tiles not yet settled
  std::size_t hashed_bands_ = 0;
  std::uint64_t written_bytes_ = 0;  // also those that were written again
  FrameDigest digest_;
};

}  // namespace tessera::master
