// SPDX-License-Identifier: Apache-2.0
// Lossless coding of a tile's pixels: components are rearranged so that a byte codec finds what
// repeats, then coded (byte_coding.h). The same bits come out. README.md says which arrangements
// were measured.
//
// Arrangement. Each component is taken as an unsigned integer of its size (the order of positive
// floats is that of their bits). From red and blue the green of the same pixel is subtracted, then
// from each value that of the pixel before it; all modulo 2^bits, so that nothing is lost. The
// differences are folded (0, -1, 1, -2 -> 0, 1, 2, 3), so that small ones of either sign have zero
// high bytes, and written byte by byte: all lowest bytes of green, of red, of blue, then the next
// bytes. Planes of the picture follow in the same way, without the green: lowest bytes of each
// channel, then the next. The arrangement follows the reversible colour transforms of JPEG-LS and
// FLIF, and the byte shuffle of HDF5 and Blosc.
//
// Threads. Any; each has its own scratch.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/base/status.h"
#include "common/frame/pixel_layout.h"
#include "common/wire/byte_coding.h"
#include "common/wire/messages.h"

namespace tessera::wire {

// Returns: false when the result would not be smaller. Requires: coding is not kNone;
// pixels.size() a multiple of layout.pixel_bytes().
[[nodiscard]] bool code_pixels(ByteCoding coding, const PixelLayout& layout,
                               std::span<const std::byte> pixels, std::vector<std::byte>& coded);

// Fills `pixels` exactly; its size comes from the lease, not from the bytes. kNone is copied.
// Returns: kDataLoss when the bytes are malformed or do not fill it. Requires: pixels.size() a
// multiple of layout.pixel_bytes().
Status restore_pixels(ByteCoding coding, const PixelLayout& layout,
                      std::span<const std::byte> coded, std::span<std::byte> pixels);

// Makes the pixels of a result plain, whatever it came in. Returns: kDataLoss when they are not the
// `plain_bytes` of its tile.
Status make_plain(const PixelLayout& layout, std::size_t plain_bytes, TileResult& result);

}  // namespace tessera::wire
