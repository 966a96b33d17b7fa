// SPDX-License-Identifier: Apache-2.0
// Camera rays of 64 pixels as a fan, and where the fans of a larger part of the picture begin. A
// packet covers 8x8 pixels. In parts that are narrower or lower than that it covers a strip, so
// that the border of a block costs rays and not packets.
//
// Threads. One object per thread.
#pragma once

#include "common/frame/tile_grid.h"
#include "slave/core/integrate/render_context.h"
#include "slave/core/surface/ray_cone.h"

namespace tessera::core {

class CameraPacket {
 public:
  FanPacket rays;
  alignas(64) std::uint32_t key[kPacketRays];  // pixel_key() of the pixels, for light

  // Requires: the context outlives it.
  explicit CameraPacket(const RenderContext& context);
  // Cone of each camera ray. It covers one sample's share of a pixel.
  RayCone cone() const;
  // Keeps the part, and finds where the traversal of all its packets begins, for all samples. Parts
  // of 32 x 32 pixels have measured best.
  void enter(const TileRect& part);
  // Pixels of a packet, whether they lie in the part or not.
  int width_px() const { return shape_.width_px; }
  int height_px() const { return shape_.height_px; }
  int column(int ray) const { return shape_.column[ray]; }
  int row(int ray) const { return shape_.row[ray]; }
  // Sets the rays through the pixels of the packet whose corner is (x, y), as far as they lie in
  // the part. Requires: enter() was called.
  void set(int x_px, int y_px, std::uint32_t sample);

 private:
  const RenderContext& context_;
  PacketShape shape_{};
  TileRect part_;
  FanEntry entry_;
};

// Number of a pixel's sample in its sequence. Each pass goes on where the one before has ended.
inline std::uint32_t sequence_index(const FrameSettings& settings, std::uint32_t sample) {
  return settings.pass * static_cast<std::uint32_t>(settings.samples_per_pixel) + sample;
}

}  // namespace tessera::core
