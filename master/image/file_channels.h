// SPDX-License-Identifier: Apache-2.0
// The channels of a picture as a file holds them: R, G, B, then those of its planes by their names
// in an EXR. A file of what a display shows (PNG, JPEG) holds colour and at most alpha.
//
// Alpha. In an EXR colour is premultiplied, as it is rendered before a background that is black. In
// a PNG it is not, as the format wants it: colour is divided by alpha while it is linear, then
// exposed and bent by the tone curve; so what covers a pixel whole has the same code as in a
// picture without alpha. Where alpha is 0 colour is black.
//
// Pixels are made for some rows at a time, so that a picture of gigabytes is written with
// megabytes.
//
// Threads. One at a time.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "master/image/oiio_plugin.h"

namespace tessera::master {

// What a file of this suffix can hold besides colour; ".exr": all planes. Requires: the suffix is
// one of OutputPattern's.
PlaneSet planes_held_by(const std::string& suffix);

class FileChannels {
 public:
  const std::vector<PluginChannel>& channels() const { return channels_; }
  std::size_t pixel_bytes() const { return pixel_bytes_; }
  // Pixels of rows [first, first + count) from the top, packed as PluginRows says; they are valid
  // until the next call. Requires: rows of the image, which outlives this.
  std::span<const std::byte> rows(int first, int count);

 private:
  friend Result<FileChannels> file_channels(const FrameImage& image, const std::string& suffix,
                                            bool is_half_exr, const DisplayTransform& display);
  FileChannels(const FrameImage& image, PixelFormat format, const DisplayTransform& display)
      : image_(&image), format_(format), display_(display) {}

  std::vector<float> plane_values(std::size_t first_pixel, std::size_t count, Plane plane) const;

  const FrameImage* image_;
  PixelFormat format_;  // of the colour in the file
  DisplayTransform display_;
  std::vector<PluginChannel> channels_;
  std::size_t pixel_bytes_ = 0;
  std::vector<float> rgb_;  // of the rows asked for last, as are those below
  std::vector<std::byte> colour_, pixels_;
};

// is_half_exr: colour of an EXR is kept as half floats; display: how linear pixels are shown, where
// the file holds what a display shows. Returns: kInvalidArgument where the file cannot hold a plane
// of the image.
Result<FileChannels> file_channels(const FrameImage& image, const std::string& suffix,
                                   bool is_half_exr, const DisplayTransform& display);

}  // namespace tessera::master
