// SPDX-License-Identifier: Apache-2.0
// The pixels of a finished frame, in the frame's own format: little-endian, row by row from the
// top, R G B; behind them its planes (pixel_layout.h). Immutable once delivered.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "common/base/api.h"
#include "common/base/digest.h"
#include "common/base/uninitialized_allocator.h"
#include "common/frame/frame_settings.h"
#include "common/frame/pixel_layout.h"
#include "common/frame/tile_grid.h"

namespace tessera {

// Every pixel of a frame is written once, and zeroing gigabytes first would hold up the thread that
// does it.
using PixelBytes = std::vector<std::byte, UninitializedAllocator<std::byte>>;

struct FrameImage {
  int width_px = 0;
  int height_px = 0;
  PixelFormat format = PixelFormat::kFloat;
  PlaneSet planes;
  PixelBytes bytes;  // [height * width * layout().pixel_bytes()]
  // [tile_count] ordinal of the slave that drew each tile, or empty
  std::vector<std::uint16_t> tile_slave;
  int tile_edge_px = 32;

  PixelLayout layout() const { return {format, planes}; }
  std::size_t pixel_count() const {
    return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }
  // Pixels of the colour, without the planes.
  std::span<const std::byte> colour() const {
    return std::span<const std::byte>(bytes).first(pixel_count() * layout().colour_bytes());
  }
  // Shape: [height * width * channels of the plane]. Requires: planes.has(plane).
  TESSERA_API std::vector<float> plane_values(Plane plane) const;

  Digest digest() const { return sha256(bytes); }
};

// Converts float RGB to `format`, appending nothing: out has count * bytes_per_pixel(format) bytes.
// Shapes: rgb [3 * count]. NaN stays NaN in float and half; in display8 it becomes 0. `display`
// applies to display8 alone; the other formats are linear.
TESSERA_API void encode_pixels(std::span<const float> rgb, PixelFormat format,
                               std::span<std::byte> out, const DisplayTransform& display = {});

// Inverse of encode_pixels(), to linear floats. display8 is decoded through the sRGB curve and
// gives light of the display.
TESSERA_API void decode_pixels(std::span<const std::byte> bytes, PixelFormat format,
                               std::span<float> rgb);

float srgb_encode(float linear);  // [0,1] -> [0,1], clamps; NaN gives 0
float srgb_decode(float encoded);

}  // namespace tessera
