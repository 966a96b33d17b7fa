// SPDX-License-Identifier: Apache-2.0
// A decoded picture as one stream of bytes, which tessera-import writes and its parent reads.
//
// Bytes, little-endian: "TSPI" u32 version; warning; u32 width, height; u8 is_display; u32 count of
// attributes, each two texts; float32 red, green, blue of each pixel, row 0 on top. A text is u32
// length and bytes. Every length is checked against what is left.
//
// Threads. Pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "master/image/image_read.h"

namespace tessera::master {

inline constexpr std::size_t kPictureAttributesMax = 1024;  // more are left out

struct PictureStream {
  FloatImage image;
  std::string warning;  // about how it was read; empty: none
};

std::vector<std::byte> encode_picture_stream(const PictureStream& stream);

// Returns: kDataLoss for anything malformed.
Result<PictureStream> decode_picture_stream(std::span<const std::byte> bytes);

}  // namespace tessera::master
