// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/frame_assembly.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/byte_text.h"
#include "master/schedule/frame_ledger.h"

namespace tessera::master {
namespace {

constexpr std::string_view kSmallerFrame =
    "render a smaller one, with fewer planes, or with --pixels half";

}  // namespace

std::string FrameAssembly::refusal(std::uint64_t needed_bytes, std::uint64_t free_bytes) {
  return "the frame needs " + mib_text(needed_bytes) + " of memory in the master, " +
         mib_text(free_bytes) + " are free; " + std::string(kSmallerFrame);
}

FrameAssembly::FrameAssembly(FrameId frame, SceneVersion version, const FrameSettings& settings,
                             FrameDigest digest)
    : settings_(settings),
      layout_(settings),
      grid_(settings.width_px, settings.height_px, settings.tile_edge_px),
      image_(std::make_shared<FrameImage>()),
      digest_(std::move(digest)) {
  stats_.frame = frame;
  stats_.scene_version = version;
  stats_.tile_count = grid_.tile_count();
  stats_.tile_edge_px = static_cast<std::uint32_t>(settings.tile_edge_px);
  image_->width_px = settings.width_px;
  image_->height_px = settings.height_px;
  image_->format = settings.pixel_format;
  image_->planes = settings.planes;
  image_->tile_edge_px = settings.tile_edge_px;
}

std::uint64_t FrameAssembly::needed_bytes() const {
  constexpr std::size_t kTileBytes = FrameLedger::bytes_per_tile() + sizeof(image_->tile_slave[0]);
  return pixel_count() * layout_.pixel_bytes() + std::uint64_t{grid_.tile_count()} * kTileBytes;
}

Status FrameAssembly::allocate() {
  const std::size_t bytes = image_->pixel_count() * layout_.pixel_bytes();
  try {
    image_->bytes.resize(bytes);
    image_->tile_slave.resize(grid_.tile_count());
    band_missing_.assign(static_cast<std::size_t>(grid_.rows()), grid_.columns());
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("the master has no memory for a frame of " +
                                      std::to_string(bytes >> 20) + " MiB; " +
                                      std::string(kSmallerFrame));
  }
  return Status::ok();
}

std::size_t FrameAssembly::tile_bytes(TileIndex tile) const {
  return static_cast<std::size_t>(grid_.rect(tile).pixel_count()) * layout_.pixel_bytes();
}

std::span<std::byte> FrameAssembly::colour_of(TileIndex tile, std::span<std::byte> pixels) const {
  return pixels.first(static_cast<std::size_t>(grid_.rect(tile).pixel_count()) *
                      layout_.colour_bytes());
}

void FrameAssembly::write_tile(TileIndex tile, std::span<const std::byte> pixels,
                               std::uint16_t slave_ordinal) {
  TESSERA_CHECK_EQ(pixels.size(), tile_bytes(tile));
  const TileRect rect = grid_.rect(tile);
  write_rows(rect, pixels, 0, layout_.colour_bytes());
  layout_.for_each_plane([&](Plane, std::size_t before_bytes, std::size_t bytes) {
    write_rows(rect, pixels, before_bytes, bytes);
  });
  image_->tile_slave[tile] = slave_ordinal;
  written_bytes_ += pixels.size();
}

void FrameAssembly::settle_tile(TileIndex tile) {
  const TileRect rect = grid_.rect(tile);
  --band_missing_[static_cast<std::size_t>(rect.y_px / settings_.tile_edge_px)];
  hash_whole_bands();
}

// Writes the colour or a plane of a tile: `bytes` bytes for each pixel, which lie behind
// `before_bytes` bytes for each pixel of the tile and of the frame.
void FrameAssembly::write_rows(const TileRect& rect, std::span<const std::byte> pixels,
                               std::size_t before_bytes, std::size_t bytes) {
  const std::size_t row_bytes = static_cast<std::size_t>(rect.width_px) * bytes;
  const std::size_t stride = static_cast<std::size_t>(settings_.width_px) * bytes;
  const std::byte* from =
      pixels.data() + static_cast<std::size_t>(rect.pixel_count()) * before_bytes;
  std::byte* to = image_->bytes.data() + image_->pixel_count() * before_bytes +
                  static_cast<std::size_t>(rect.y_px) * stride +
                  static_cast<std::size_t>(rect.x_px) * bytes;
  for (int row = 0; row < rect.height_px; ++row) {
    std::memcpy(to, from, row_bytes);
    from += row_bytes;
    to += stride;
  }
}

std::size_t FrameAssembly::band_bytes() const {
  return static_cast<std::size_t>(settings_.tile_edge_px) *
         static_cast<std::size_t>(settings_.width_px) * layout_.colour_bytes();
}

void FrameAssembly::hash_whole_bands() {
  const std::size_t colour_bytes = image_->colour().size();
  while (hashed_bands_ < band_missing_.size() && band_missing_[hashed_bands_] == 0) {
    const std::size_t begin = hashed_bands_++ * band_bytes();
    digest_.update(image_, begin, std::min(band_bytes(), colour_bytes - begin));
  }
}

FrameDigest FrameAssembly::take_digest() {
  const std::size_t begin = std::min(hashed_bands_ * band_bytes(), image_->colour().size());
  if (image_->bytes.size() > begin) digest_.update(image_, begin, image_->bytes.size() - begin);
  return std::move(digest_);
}

}  // namespace tessera::master
