// SPDX-License-Identifier: Apache-2.0
// The same bits come out of every coding in every format; damaged and lying bytes are refused.
#include "common/wire/pixel_coding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "common/frame/frame_image.h"
#include "tests/support/seed.h"

namespace tessera::wire {
namespace {

constexpr std::array kFormats = {PixelFormat::kFloat, PixelFormat::kHalf, PixelFormat::kDisplay8};
constexpr std::array kCodecs = {ByteCoding::kLz4, ByteCoding::kZstd};

// A smooth tile, which shrinks.
std::vector<std::byte> smooth_tile(PixelFormat format, int edge) {
  std::vector<float> rgb;
  for (int y = 0; y < edge; ++y) {
    for (int x = 0; x < edge; ++x) {
      const float light = 0.2f + 0.5f * static_cast<float>(x + y) / static_cast<float>(edge);
      rgb.insert(rgb.end(), {light, 0.8f * light, 0.7f * light});
    }
  }
  std::vector<std::byte> pixels(rgb.size() / 3 * static_cast<std::size_t>(bytes_per_pixel(format)));
  encode_pixels(rgb, format, pixels);
  return pixels;
}

TEST(PixelCoding, TheSameBitsComeOut) {
  std::mt19937 random(test::seed(7));
  for (const PixelFormat format : kFormats) {
    const auto pixel_bytes = static_cast<std::size_t>(bytes_per_pixel(format));
    for (const ByteCoding coding : kCodecs) {
      for (const std::size_t count : {1u, 2u, 15u, 1024u, 65536u}) {
        // Arbitrary bits, NaN and infinities among them, with runs so that there is what to code.
        std::vector<std::byte> pixels(count * pixel_bytes);
        for (std::size_t i = 0; i < pixels.size(); ++i) {
          pixels[i] =
              i > 64 && random() % 8 != 0 ? pixels[i - 12] : static_cast<std::byte>(random());
        }
        std::vector<std::byte> coded;
        if (!code_pixels(coding, format, pixels, coded)) continue;
        EXPECT_LT(coded.size(), pixels.size());
        std::vector<std::byte> again(pixels.size());
        ASSERT_TRUE(restore_pixels(coding, format, coded, again).is_ok());
        ASSERT_EQ(again, pixels) << coding_name(coding) << " of " << count;
      }
    }
  }
}

TEST(PixelCoding, PlanesComeOutWithTheSameBits) {
  std::mt19937 random(test::seed(8));
  for (const PixelFormat format : kFormats) {
    for (const PlaneSet planes :
         {PlaneSet{Plane::kAlpha}, PlaneSet{Plane::kNormal, Plane::kObject}, PlaneSet::all()}) {
      const PixelLayout layout(format, planes);
      for (const ByteCoding coding : kCodecs) {
        for (const std::size_t count : {1u, 63u, 1024u}) {
          std::vector<std::byte> pixels(count * layout.pixel_bytes());
          for (std::size_t i = 0; i < pixels.size(); ++i)
            pixels[i] =
                i > 64 && random() % 8 != 0 ? pixels[i - 4] : static_cast<std::byte>(random());
          std::vector<std::byte> coded, again(pixels.size());
          if (!code_pixels(coding, layout, pixels, coded)) continue;
          ASSERT_TRUE(restore_pixels(coding, layout, coded, again).is_ok());
          ASSERT_EQ(again, pixels) << coding_name(coding) << " of " << count;
        }
      }
    }
  }
}

TEST(PixelCoding, APlaneThatIsFlatCostsNextToNothing) {
  const PixelLayout layout(PixelFormat::kFloat, {Plane::kObject, Plane::kMaterial});
  const std::vector<std::byte> colour = smooth_tile(PixelFormat::kFloat, 32);
  std::vector<std::byte> pixels = colour, alone, both;
  for (int i = 0; i < 2 * 32 * 32; ++i) {
    const float id = 7;
    const auto* bytes = reinterpret_cast<const std::byte*>(&id);
    pixels.insert(pixels.end(), bytes, bytes + 4);
  }
  ASSERT_TRUE(code_pixels(ByteCoding::kZstd, PixelFormat::kFloat, colour, alone));
  ASSERT_TRUE(code_pixels(ByteCoding::kZstd, layout, pixels, both));
  EXPECT_LT(both.size(), alone.size() + 200) << "of " << 2 * 4 * 32 * 32;
}

TEST(PixelCoding, SmoothTilesShrinkAndNoiseIsLeftAlone) {
  std::mt19937 random(test::seed(3));
  for (const PixelFormat format : kFormats) {
    for (const ByteCoding coding : kCodecs) {
      std::vector<std::byte> pixels = smooth_tile(format, 32), coded;
      ASSERT_TRUE(code_pixels(coding, format, pixels, coded));
      for (std::byte& b : pixels) b = static_cast<std::byte>(random());
      EXPECT_FALSE(code_pixels(coding, format, pixels, coded));
    }
  }
}

TEST(PixelCoding, DamagedBytesAreRefusedOrFillTheTileAndNoMore) {
  std::mt19937 random(test::seed(11));
  for (const ByteCoding coding : kCodecs) {
    const std::vector<std::byte> pixels = smooth_tile(PixelFormat::kFloat, 32);
    std::vector<std::byte> coded;
    ASSERT_TRUE(code_pixels(coding, PixelFormat::kFloat, pixels, coded));
    std::vector<std::byte> out(pixels.size());
    for (int i = 0; i < 2000; ++i) {
      std::vector<std::byte> bad = coded;
      bad[random() % bad.size()] ^= static_cast<std::byte>(1 + random() % 255);
      if (i % 3 == 0) bad.resize(random() % bad.size());
      (void)restore_pixels(coding, PixelFormat::kFloat, bad, out);  // sanitizers see stray accesses
    }
    EXPECT_FALSE(restore_pixels(coding, PixelFormat::kFloat, {}, out).is_ok());
  }
}

TEST(PixelCoding, ABombIsRefused) {
  // A coded tile of zeros that is 16 times the one leased.
  const std::vector<std::byte> zeros(std::size_t{12} * 128 * 128);
  std::vector<std::byte> room(std::size_t{12} * 32 * 32), coded;
  for (const ByteCoding coding : kCodecs) {
    ASSERT_TRUE(code_pixels(coding, PixelFormat::kFloat, zeros, coded));
    EXPECT_FALSE(restore_pixels(coding, PixelFormat::kFloat, coded, room).is_ok());
    std::vector<std::byte> larger(2 * zeros.size());
    EXPECT_FALSE(restore_pixels(coding, PixelFormat::kFloat, coded, larger).is_ok()) << "too few";
  }
}

TEST(PixelCoding, AResultBecomesPlain) {
  const std::vector<std::byte> pixels = smooth_tile(PixelFormat::kHalf, 16);
  TileResult result;
  result.coding = ByteCoding::kZstd;
  ASSERT_TRUE(code_pixels(result.coding, PixelFormat::kHalf, pixels, result.pixels));
  ASSERT_TRUE(make_plain(PixelFormat::kHalf, pixels.size(), result).is_ok());
  EXPECT_EQ(result.pixels, pixels);
  EXPECT_EQ(result.coding, ByteCoding::kNone);
  EXPECT_TRUE(make_plain(PixelFormat::kHalf, pixels.size(), result).is_ok());
  EXPECT_FALSE(make_plain(PixelFormat::kHalf, pixels.size() + 6, result).is_ok());
}

}  // namespace
}  // namespace tessera::wire
