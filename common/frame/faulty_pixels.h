// SPDX-License-Identifier: Apache-2.0
// Pixels that cannot be light: NaN, infinite or negative components. They are found tile by tile,
// before a tone map or an average spreads them, and painted over with a colour that nobody takes
// for a picture.
//
// Threads. Plain functions.
//
// Display8 has no such values: 0 pixels are faulty there. -0 is as good as 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/frame/frame_settings.h"

namespace tessera {

// Linear red, green, blue of the error colour, which is magenta.
inline constexpr float kErrorColour[3] = {1, 0, 1};

// Number of pixels with at least one faulty component. Requires: whole pixels.
std::uint64_t count_faulty_pixels(std::span<const std::byte> bytes, PixelFormat format);

// Paints the faulty pixels in the error colour. Returns: how many there are.
std::uint64_t paint_faulty_pixels(std::span<std::byte> bytes, PixelFormat format);

}  // namespace tessera
