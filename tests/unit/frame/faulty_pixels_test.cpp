// SPDX-License-Identifier: Apache-2.0
// Faulty pixels are found and painted, and no others.
#include "common/frame/faulty_pixels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "common/frame/frame_image.h"

namespace tessera {
namespace {

std::vector<std::byte> encoded(const std::vector<float>& rgb, PixelFormat format) {
  std::vector<std::byte> bytes(rgb.size() / 3 * static_cast<std::size_t>(bytes_per_pixel(format)));
  encode_pixels(rgb, format, bytes);
  return bytes;
}

TEST(FaultyPixels, NanInfinityAndNegativeArePaintedAndNothingElse) {
  const float nan = std::nanf("");
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> picture = {0,      0.5f, 1,     //
                                      nan,    0,    0,     //
                                      0,      inf,  0,     //
                                      0,      0,    -inf,  //
                                      -0.25f, 1,    1,     //
                                      -0.0f,  0,    2,     //
                                      0,      0,    60000.f};
  std::vector<float> mended = picture;
  for (const std::size_t pixel : {1u, 2u, 3u, 4u})
    for (std::size_t c = 0; c < 3; ++c) mended[3 * pixel + c] = kErrorColour[c];
  for (const PixelFormat format : {PixelFormat::kFloat, PixelFormat::kHalf}) {
    std::vector<std::byte> bytes = encoded(picture, format);
    EXPECT_EQ(count_faulty_pixels(bytes, format), 4u);
    EXPECT_EQ(paint_faulty_pixels(bytes, format), 4u);
    EXPECT_EQ(bytes, encoded(mended, format));
    EXPECT_EQ(count_faulty_pixels(bytes, format), 0u);
  }
}

// Counts faulty pixels where one component is `unusual` and the others are `usual`.
template <typename Bits>
std::uint64_t count(PixelFormat format, Bits usual, unsigned unusual, std::size_t place) {
  std::vector<Bits> components(75, usual);  // an odd count, so that components straddle words
  components[place] = static_cast<Bits>(unusual);
  return count_faulty_pixels(std::as_bytes(std::span(components)), format);
}

TEST(FaultyPixels, AreFoundWhereverTheyStand) {
  for (std::size_t place = 0; place < 75; ++place) {
    for (const unsigned bad : {0x7c00u, 0xfc00u, 0x7e01u, 0xffffu, 0x8001u, 0xbc00u})
      EXPECT_EQ(count<std::uint16_t>(PixelFormat::kHalf, 0x7bff, bad, place), 1u) << place;
    for (const unsigned bad : {0x7f800000u, 0xff800000u, 0x7fc00001u, 0xffffffffu, 0x80000001u})
      EXPECT_EQ(count<std::uint32_t>(PixelFormat::kFloat, 0x7f7fffff, bad, place), 1u) << place;
  }
  for (const unsigned good : {0x0000u, 0x8000u, 0x0001u, 0x7bffu, 0x03ffu})
    EXPECT_EQ(count<std::uint16_t>(PixelFormat::kHalf, 0x7bff, good, 3), 0u);
  for (const unsigned good : {0u, 0x80000000u, 1u, 0x7f7fffffu, 0x007fffffu})
    EXPECT_EQ(count<std::uint32_t>(PixelFormat::kFloat, 0x7f7fffff, good, 3), 0u);
}

TEST(FaultyPixels, DisplayPixelsHaveNoFaultyValues) {
  std::vector<std::byte> bytes(30, std::byte{0xff});
  EXPECT_EQ(paint_faulty_pixels(bytes, PixelFormat::kDisplay8), 0u);
}

}  // namespace
}  // namespace tessera
