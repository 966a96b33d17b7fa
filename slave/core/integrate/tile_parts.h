// SPDX-License-Identifier: Apache-2.0
// Goes through a tile in parts of up to 32 x 32 pixels, each of them sample by sample and packet by
// packet, for the renderers that look at one packet of camera rays after another.
//
// Threads. One object per thread.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "common/frame/tile_grid.h"
#include "slave/core/integrate/camera_packet.h"
#include "slave/core/scene/surface_batch.h"

namespace tessera::core {

// Up to 4x4 packets are traced before they are shaded together, so that coherent shadow rays are
// found among them.
inline constexpr int kPartEdgePx = 32;
static_assert(kPartEdgePx * kPartEdgePx == kBatchMax);

// Sums of samples, by pixel of a part: kPartEdgePx in a row.
struct PartPixels {
  Vec3f radiance[kBatchMax];

  // Shape: rgb [3 * tile.pixel_count()].
  void write(const TileRect& part, const TileRect& tile, int samples, std::span<float> rgb) const {
    const float scale = 1 / static_cast<float>(samples);
    for (int y = 0; y < part.height_px; ++y) {
      for (int x = 0; x < part.width_px; ++x) {
        const int column = part.x_px + x - tile.x_px, row = part.y_px + y - tile.y_px;
        const auto at = 3 * static_cast<std::size_t>(row * tile.width_px + column);
        for (int c = 0; c < 3; ++c)
          rgb[at + static_cast<std::size_t>(c)] = radiance[y * kPartEdgePx + x][c] * scale;
      }
    }
  }
};

class TileParts {
 public:
  // Requires: the context outlives it.
  explicit TileParts(const RenderContext& context) : context_(context), camera_(context) {}

  const CameraPacket& camera() const { return camera_; }
  // Pixel of a ray in its part. (x, y): corner of the packet in the part.
  int pixel(int x, int y, int ray) const {
    return (y + camera_.row(ray)) * kPartEdgePx + x + camera_.column(ray);
  }

  // For each part and sample, calls begin_sample(number), packet(x, y) for each packet at (x, y) of
  // the part, with its hits in `hits`, and end_sample(); then writes the part. Returns: camera rays
  // traced. Once the context is over it returns early, and what is written is to be thrown away.
  template <class Renderer>
  std::uint64_t render(Renderer& renderer, PacketHits& hits, PartPixels& pixels,
                       const TileRect& tile, std::span<float> rgb) {
    std::uint64_t rays = 0;
    for (int y = 0; y < tile.height_px; y += kPartEdgePx) {
      for (int x = 0; x < tile.width_px; x += kPartEdgePx) {
        if (context_.is_over()) return rays;
        const TileRect part{tile.x_px + x, tile.y_px + y, std::min(kPartEdgePx, tile.width_px - x),
                            std::min(kPartEdgePx, tile.height_px - y)};
        std::fill(std::begin(pixels.radiance), std::end(pixels.radiance), Vec3f{});
        rays += render_part(renderer, hits, part);
        pixels.write(part, tile, context_.settings.samples_per_pixel, rgb);
      }
    }
    return rays;
  }

 private:
  template <class Renderer>
  std::uint64_t render_part(Renderer& renderer, PacketHits& hits, const TileRect& part) {
    std::uint64_t rays = 0;
    camera_.enter(part);
    const auto samples = static_cast<std::uint32_t>(context_.settings.samples_per_pixel);
    for (std::uint32_t sample = 0; sample < samples; ++sample) {
      renderer.begin_sample(sample);
      for (int y = 0; y < part.height_px; y += camera_.height_px()) {
        for (int x = 0; x < part.width_px; x += camera_.width_px()) {
          if (context_.is_over()) return rays;
          camera_.set(part.x_px + x, part.y_px + y, sample);
          context_.tracer.closest(camera_.rays, hits);
          rays += static_cast<std::uint64_t>(std::popcount(camera_.rays.active));
          renderer.packet(x, y);
        }
      }
      renderer.end_sample();
    }
    return rays;
  }

  const RenderContext& context_;
  CameraPacket camera_;
};

}  // namespace tessera::core
