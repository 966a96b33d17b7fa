// SPDX-License-Identifier: Apache-2.0
// The channels of a picture as a file holds them: R, G, B, then those of its planes by their names
// in an EXR. A file of what a display shows (PNG, JPEG) holds colour and at most alpha.
//
// Alpha. In an EXR colour is premultiplied, as it is rendered before a background that is black. In
// a PNG it is not, as the format wants it: colour is divided by alpha while it is linear, then
// exposed and bent by the tone curve; so what covers a pixel whole has the same code as in a
// picture without alpha. Where alpha is 0 colour is black.
//
// Threads. Plain values and pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/frame/frame_image.h"
#include "master/image/oiio_plugin.h"

namespace tessera::master {

struct FileChannels {
  std::vector<PluginChannel> channels;
  std::vector<std::byte> pixels;  // packed, as PluginPixelRows says
};

// What a file of this suffix can hold besides colour; ".exr": all planes. Requires: the suffix is
// one of OutputPattern's.
PlaneSet planes_held_by(const std::string& suffix);

// is_half_exr: colour of an EXR is kept as half floats; display: how linear pixels are shown, where
// the file holds what a display shows. Returns: kInvalidArgument where the file cannot hold a plane
// of the image.
Result<FileChannels> file_channels(const FrameImage& image, const std::string& suffix,
                                   bool is_half_exr, const DisplayTransform& display);

}  // namespace tessera::master
