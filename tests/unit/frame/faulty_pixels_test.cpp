// Faulty pixels are found and painted, and no others.
#include "common/frame/faulty_pixels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
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

TEST(FaultyPixels, DisplayPixelsHaveNoFaultyValues) {
  std::vector<std::byte> bytes(30, std::byte{0xff});
  EXPECT_EQ(paint_faulty_pixels(bytes, PixelFormat::kDisplay8), 0u);
}

}  // namespace
}  // namespace tessera
