// SPDX-License-Identifier: Apache-2.0
// Channels that a file gets of a picture with planes: their names, kinds of numbers, alpha.
#include "master/image/file_channels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "master/image/image_file.h"
#include "master/image/image_read.h"
#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

constexpr std::size_t kPixels = 4;

// A picture whose colour is premultiplied, as it is rendered.
FrameImage picture(PlaneSet planes, PixelFormat format = PixelFormat::kFloat) {
  FrameImage image;
  image.width_px = 2;
  image.height_px = 2;
  image.format = format;
  image.planes = planes;
  image.bytes.resize(kPixels * image.layout().pixel_bytes());
  const float rgb[] = {0.8f, 0.4f, 0.2f, 0.4f, 0.2f, 0.1f, 0, 0, 0, 0.2f, 0.1f, 0.05f};
  encode_pixels(rgb, format, std::span(image.bytes).first(kPixels * image.layout().colour_bytes()));
  image.layout().for_each_plane([&](Plane plane, std::size_t before_bytes, std::size_t bytes) {
    std::vector<float> values{1, 0.5f, 0, 0.25f};
    if (plane != Plane::kAlpha) {
      values.clear();
      for (std::size_t i = 0; i < bytes; ++i) values.push_back(static_cast<float>(10 * i));
    }
    std::memcpy(image.bytes.data() + kPixels * before_bytes, values.data(), kPixels * bytes);
  });
  return image;
}

// All rows of a picture as its file holds them, put together of bands of `band_rows` rows.
struct Packed {
  std::vector<PluginChannel> channels;
  std::vector<std::byte> pixels;
};
Result<Packed> packed(const FrameImage& image, const std::string& suffix, bool is_half_exr = false,
                      int band_rows = 1) {
  auto file = file_channels(image, suffix, is_half_exr, {});
  if (!file.is_ok()) return file.status();
  Packed all{file->channels(), {}};
  for (int row = 0; row < image.height_px; row += band_rows) {
    const auto rows = file->rows(row, std::min(band_rows, image.height_px - row));
    all.pixels.insert(all.pixels.end(), rows.begin(), rows.end());
  }
  return all;
}

std::vector<std::string> names(const Packed& file) {
  std::vector<std::string> all;
  for (const PluginChannel& channel : file.channels) all.emplace_back(channel.name);
  return all;
}

float float_at(const Packed& file, std::size_t byte) {
  float value = 0;
  std::memcpy(&value, file.pixels.data() + byte, sizeof(value));
  return value;
}

TEST(FileChannels, WithoutPlanesAFileHasColourAlone) {
  const auto file = packed(picture({}), ".exr");
  ASSERT_TRUE(file.is_ok());
  EXPECT_EQ(names(*file), (std::vector<std::string>{"R", "G", "B"}));
  const FrameImage image = picture({});
  EXPECT_TRUE(
      std::equal(file->pixels.begin(), file->pixels.end(), image.bytes.begin(), image.bytes.end()));
}

TEST(FileChannels, AnExrHasAllUnderTheirUsualNames) {
  const FrameImage image = picture(PlaneSet::all());
  const auto file = packed(image, ".exr");
  ASSERT_TRUE(file.is_ok());
  EXPECT_EQ(names(*file), (std::vector<std::string>{
                              "R", "G", "B", "A", "albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y",
                              "N.Z", "Z", "P.X", "P.Y", "P.Z", "object", "material", "samples"}));
  const std::size_t pixel_bytes = 4 * file->channels.size();
  ASSERT_EQ(file->pixels.size(), kPixels * pixel_bytes);
  for (std::size_t i = 0; i < kPixels; ++i) {
    EXPECT_EQ(float_at(*file, i * pixel_bytes + 12), image.plane_values(Plane::kAlpha)[i]);
    EXPECT_EQ(float_at(*file, i * pixel_bytes + 32), image.plane_values(Plane::kNormal)[3 * i + 1]);
    EXPECT_EQ(float_at(*file, i * pixel_bytes + 40), image.plane_values(Plane::kDepth)[i]);
  }
}

TEST(FileChannels, ColourMayBeHalfAndPlanesStayFloat) {
  const FrameImage image = picture({Plane::kDepth}, PixelFormat::kHalf);
  const auto file = packed(image, ".exr", true);
  ASSERT_TRUE(file.is_ok());
  EXPECT_EQ(file->channels[0].type, PluginPixels::kHalf);
  EXPECT_EQ(file->channels[3].type, PluginPixels::kFloat);
  ASSERT_EQ(file->pixels.size(), kPixels * 10);
  for (std::size_t i = 0; i < kPixels; ++i) {
    EXPECT_EQ(float_at(*file, 10 * i + 6), image.plane_values(Plane::kDepth)[i]);
    EXPECT_EQ(std::memcmp(file->pixels.data() + 10 * i, image.bytes.data() + 6 * i, 6), 0);
  }
}

// Colour that covers a pixel in part has the code of the same light that covers it whole.
TEST(FileChannels, APngHasAlphaThatIsNotMultipliedIn) {
  const auto file = packed(picture({Plane::kAlpha}), ".png");
  ASSERT_TRUE(file.is_ok());
  ASSERT_EQ(file->pixels.size(), kPixels * 4);
  const auto code = [&](std::size_t pixel, std::size_t c) {
    return std::to_integer<int>(file->pixels[4 * pixel + c]);
  };
  const int alpha[] = {255, 128, 0, 64};
  for (std::size_t pixel = 0; pixel < kPixels; ++pixel) {
    EXPECT_EQ(code(pixel, 3), alpha[pixel]);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(code(pixel, c), pixel == 2 ? 0 : code(0, c));
  }
  EXPECT_EQ(code(0, 0), 231) << "sRGB of 0.8";
}

TEST(FileChannels, BandsOfAnyHeightAreTheSamePixels) {
  for (const char* suffix : {".exr", ".png"}) {
    const FrameImage image = picture({Plane::kAlpha});
    const auto by_rows = packed(image, suffix, false, 1), whole = packed(image, suffix, false, 2);
    ASSERT_TRUE(by_rows.is_ok() && whole.is_ok());
    EXPECT_EQ(by_rows->pixels, whole->pixels) << suffix;
  }
}

TEST(FileChannels, WhatAFileCannotHoldIsRefused) {
  for (const char* suffix : {".jpg", ".jpeg", ".hdr", ".pfm"})
    EXPECT_FALSE(file_channels(picture({Plane::kAlpha}), suffix, false, {}).is_ok()) << suffix;
  EXPECT_FALSE(file_channels(picture({Plane::kDepth}), ".png", false, {}).is_ok());
  const test::TempFolder folder;
  for (const char* name : {"a.jpg", "a.pfm", "a.hdr"}) {
    const Status status = write_image(picture({Plane::kAlpha}), folder / name, {});
    EXPECT_NE(status.message().find(name), std::string::npos) << status.message();
    EXPECT_NE(status.message().find("OUT.exr"), std::string::npos) << status.message();
  }
}

// The image library puts R, G, B first again when it reads, whatever else a file has.
TEST(FileChannels, ColourIsReadBackToTheBit) {
  const test::TempFolder folder;
  for (const PlaneSet planes : {PlaneSet{Plane::kAlpha}, PlaneSet::all()}) {
    const FrameImage image = picture(planes);
    ASSERT_TRUE(write_image(image, folder / "a.exr", {}).is_ok());
    const auto read = read_image(folder / "a.exr");
    ASSERT_TRUE(read.is_ok()) << read.status().message();
    ASSERT_EQ(read->rgb.size(), 3 * kPixels);
    EXPECT_EQ(std::memcmp(read->rgb.data(), image.bytes.data(), 12 * kPixels), 0);
  }
}

}  // namespace
}  // namespace tessera::master
