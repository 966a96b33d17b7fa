#include "common/frame/frame_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace tessera {
namespace {

std::vector<float> through(PixelFormat format, std::vector<float> rgb) {
  std::vector<std::byte> bytes(rgb.size() / 3 * static_cast<std::size_t>(bytes_per_pixel(format)));
  encode_pixels(rgb, format, bytes);
  std::vector<float> back(rgb.size());
  decode_pixels(bytes, format, back);
  return back;
}

TEST(FrameImage, FloatPixelsKeepEveryBit) {
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> rgb{0, -0.0f, 1e-42f, 3.5f, -1e30f, inf};
  const std::vector<float> back = through(PixelFormat::kFloat, rgb);
  EXPECT_EQ(std::memcmp(back.data(), rgb.data(), rgb.size() * sizeof(float)), 0);
}

TEST(FrameImage, HalfPixelsRoundToNearestEven) {
  // 2049 and 2051 lie between halves 2048, 2050, 2052; 65504 is the greatest half; 2^-24 the least.
  const std::vector<float> back =
      through(PixelFormat::kHalf, {2049, 2051, 65504, 0x1p-24f, 0x1p-26f, 1.0f / 3});
  EXPECT_EQ(back[0], 2048);
  EXPECT_EQ(back[1], 2052);
  EXPECT_EQ(back[2], 65504);
  EXPECT_EQ(back[3], 0x1p-24f);
  EXPECT_EQ(back[4], 0);
  EXPECT_NEAR(back[5], 1.0f / 3, 0x1p-13f);
}

TEST(FrameImage, EveryFiniteHalfSurvivesTheWayThere) {
  for (std::uint32_t bits = 0; bits < 0x7c00; ++bits) {
    const std::uint16_t half = static_cast<std::uint16_t>(bits);
    std::vector<std::byte> bytes(6);
    for (int i = 0; i < 3; ++i) std::memcpy(bytes.data() + 2 * i, &half, 2);
    std::vector<float> rgb(3);
    decode_pixels(bytes, PixelFormat::kHalf, rgb);
    std::vector<std::byte> again(6);
    encode_pixels(rgb, PixelFormat::kHalf, again);
    ASSERT_EQ(again, bytes) << "half " << bits << " = " << rgb[0];
  }
}

TEST(FrameImage, NanStaysNanAndIsBlackOnADisplay) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isnan(through(PixelFormat::kFloat, {nan, 0, 0})[0]));
  EXPECT_TRUE(std::isnan(through(PixelFormat::kHalf, {nan, 0, 0})[0]));
  EXPECT_EQ(through(PixelFormat::kDisplay8, {nan, 0, 0})[0], 0);
}

TEST(FrameImage, DisplayPixelsFollowTheSrgbCurve) {
  // IEC 61966-2-1: 0.5 encodes to 0.7353..., that is 188 of 255.
  std::vector<std::byte> bytes(3);
  encode_pixels(std::vector<float>{0.5f, 2.0f, -1.0f}, PixelFormat::kDisplay8, bytes);
  EXPECT_EQ(bytes, (std::vector<std::byte>{std::byte{188}, std::byte{255}, std::byte{0}}));
  for (int i = 0; i <= 255; ++i) {
    const float encoded = static_cast<float>(i) / 255;
    EXPECT_NEAR(srgb_encode(srgb_decode(encoded)), encoded, 1e-6f);
  }
}

TEST(FrameImage, DigestCoversEveryByte) {
  FrameImage image;
  image.bytes.resize(300);
  const Digest before = image.digest();
  image.bytes[299] = std::byte{1};
  EXPECT_NE(image.digest(), before);
}

}  // namespace
}  // namespace tessera
