// SPDX-License-Identifier: Apache-2.0
// How the pixels of a tile or a frame lie in memory and on the wire: first all of the colour, row
// by row, in its format; behind it the planes that were asked for, by rising number, each row by
// row as float32 with the channels of a pixel side by side. So colour lies as it does without
// planes.
//
// Threads. Plain values.
#pragma once

#include <cstddef>

#include "common/frame/frame_settings.h"
#include "common/frame/picture_plane.h"

namespace tessera {

class PixelLayout {
 public:
  PixelLayout(PixelFormat format, PlaneSet planes = {})
      : format_(format),
        planes_(planes),
        plane_bytes_(planes.is_empty() ? 0 : sizeof(float) * channel_count(planes)) {}
  explicit PixelLayout(const FrameSettings& settings)
      : PixelLayout(settings.pixel_format, settings.planes) {}

  PixelFormat format() const { return format_; }
  PlaneSet planes() const { return planes_; }
  // Bytes of one pixel: those of its colour, and those of the colour and all planes.
  std::size_t colour_bytes() const { return static_cast<std::size_t>(bytes_per_pixel(format_)); }
  std::size_t pixel_bytes() const { return colour_bytes() + plane_bytes_; }

  // Calls function(plane, before_bytes, bytes) for each plane. One pixel has `bytes` bytes in the
  // plane, and `before_bytes` in the colour and the planes before it. The plane of n pixels begins
  // at byte n * before_bytes.
  template <class Function>
  void for_each_plane(const Function& function) const {
    std::size_t before_bytes = colour_bytes();
    planes_.for_each([&](Plane plane) {
      const std::size_t bytes = sizeof(float) * plane_row(plane).channel_count();
      function(plane, before_bytes, bytes);
      before_bytes += bytes;
    });
  }

  bool operator==(const PixelLayout&) const = default;

 private:
  PixelFormat format_;
  PlaneSet planes_;
  std::size_t plane_bytes_;
};

}  // namespace tessera
