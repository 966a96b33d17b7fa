// SPDX-License-Identifier: Apache-2.0
#include "common/frame/frame_image.h"
#include "tests/support/seed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace tessera {
namespace {

float through_one(PixelFormat format, float value) {
  const float rgb[3] = {value, value, value};
  std::vector<std::byte> bytes(static_cast<std::size_t>(bytes_per_pixel(format)));
  encode_pixels(rgb, format, bytes);
  float out[3] = {};
  decode_pixels(bytes, format, out);
  return out[0];
}

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

// Half floats have the errors that --help and common/wire/README.md state, over all magnitudes.
TEST(FrameImage, HalfHasTheStatedError) {
  std::mt19937 random(test::seed(5));
  double relative = 0, absolute_small = 0;
  for (int i = 0; i < 300'000; ++i) {
    const auto bits = static_cast<std::uint32_t>(random()) & 0x7fffffffu;
    const float value = std::bit_cast<float>(bits);
    if (!(value < 65520)) continue;
    const double error =
        std::abs(static_cast<double>(through_one(PixelFormat::kHalf, value)) - double{value});
    if (value >= 0x1p-14f) {
      relative = std::max(relative, error / value);
    } else {
      absolute_small = std::max(absolute_small, error);
    }
  }
  EXPECT_LE(relative, 0x1p-11);
  EXPECT_GE(relative, 0x1p-11 * 0.99) << "the bound is not slack";
  EXPECT_LE(absolute_small, 0x1p-25);
  EXPECT_EQ(through_one(PixelFormat::kHalf, std::nextafter(65520.0f, 0.0f)), 65504);
  EXPECT_TRUE(std::isinf(through_one(PixelFormat::kHalf, 65520)));
  EXPECT_TRUE(std::isnan(through_one(PixelFormat::kHalf, std::nanf(""))));
}

TEST(FrameImage, Display8IsHalfACodeOff) {
  double worst = 0;
  for (int i = 0; i <= 1'000'000; ++i) {
    const double linear = static_cast<double>(static_cast<float>(i * 1e-6));
    const double exact =
        255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055);
    const float rgb[3] = {static_cast<float>(linear), 0, 0};
    std::array<std::byte, 3> code{};
    encode_pixels(rgb, PixelFormat::kDisplay8, code);
    worst = std::max(worst, std::abs(static_cast<double>(code[0]) - exact));
  }
  // Besides the rounding to a code, the error has that of float pow, scale and sum, together below
  // 8 roundings at 255, and that of the standard's two pieces, which differ by less than 1e-4 of a
  // code where they meet.
  EXPECT_LE(worst, 0.5 + 255 * 8 * 0x1p-24 + 1e-4);
  EXPECT_GE(worst, 0.49);
  const float outside[3] = {-1, 7, std::nanf("")};
  std::array<std::byte, 3> codes{};
  encode_pixels(outside, PixelFormat::kDisplay8, codes);
  EXPECT_EQ(codes, (std::array<std::byte, 3>{std::byte{0}, std::byte{255}, std::byte{0}}));
}

}  // namespace
}  // namespace tessera
