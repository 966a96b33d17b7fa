// SPDX-License-Identifier: Apache-2.0
#include "master/image/image_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "master/image/image_read.h"
#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

constexpr int kWidth = 37, kHeight = 21;

std::vector<float> sample_pixels() {
  std::vector<float> rgb(3 * kWidth * kHeight);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = 0.01f * static_cast<float>(i % 211);
  return rgb;
}

FrameImage sample_image(PixelFormat format = PixelFormat::kFloat) {
  FrameImage image;
  image.width_px = kWidth;
  image.height_px = kHeight;
  image.format = format;
  image.bytes.resize(static_cast<std::size_t>(kWidth * kHeight * bytes_per_pixel(format)));
  encode_pixels(sample_pixels(), format, image.bytes);
  return image;
}

class ImageFile : public ::testing::Test {
 protected:
  std::vector<float> through(const std::string& name, const WriteOptions& options = {}) {
    const Status written = write_image(sample_image(), folder_ / name, options);
    EXPECT_TRUE(written.is_ok()) << written.message();
    auto read = read_image(folder_ / name);
    EXPECT_TRUE(read.is_ok()) << read.status().message();
    if (!read.is_ok()) return {};
    EXPECT_EQ(read->width_px, kWidth);
    EXPECT_EQ(read->height_px, kHeight);
    return read->rgb;
  }
  std::size_t file_count() const {
    const auto files = std::filesystem::directory_iterator(folder_.path());
    return static_cast<std::size_t>(std::distance(begin(files), end(files)));
  }
  const test::TempFolder folder_;
};

TEST_F(ImageFile, FloatFormatsKeepLinearRadianceToTheBit) {
  EXPECT_EQ(through("a.exr"), sample_pixels());
  EXPECT_EQ(through("a.pfm"), sample_pixels());
}

TEST_F(ImageFile, HalfExrIsRoundedOnly) {
  const std::vector<float> expected = sample_pixels(), rgb = through("h.exr", {true});
  ASSERT_EQ(rgb.size(), expected.size());
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    ASSERT_NEAR(rgb[i], expected[i], std::abs(expected[i]) * 0x1p-11f);
  }
}

TEST_F(ImageFile, HdrIsLinearWithinItsSharedExponent) {
  const std::vector<float> expected = sample_pixels(), rgb = through("a.hdr");
  ASSERT_EQ(rgb.size(), expected.size());
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    const float most = std::max({expected[i], expected[i + 1], expected[i + 2]});
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(rgb[i + c], expected[i + c], most / 128);
  }
}

// Half a step of 255 is at most this much light, since the curve is steepest at its end, 2.27.
TEST_F(ImageFile, PngIsSrgbEncodedAndReadAsLight) {
  const std::vector<float> expected = sample_pixels(), rgb = through("a.png");
  ASSERT_EQ(rgb.size(), expected.size());
  for (std::size_t i = 0; i < rgb.size(); ++i)
    ASSERT_NEAR(rgb[i], std::min(expected[i], 1.0f), 2.28f * 0.51f / 255) << i;
}

TEST_F(ImageFile, JpegIsWrittenAndCloseToThePicture) {
  FrameImage image = sample_image();
  std::vector<float> smooth(3 * kWidth * kHeight);
  for (std::size_t i = 0; i < smooth.size(); ++i)
    smooth[i] = 0.2f + 0.6f * static_cast<float>(i / 3 % kWidth) / kWidth;
  encode_pixels(smooth, image.format, image.bytes);
  for (const char* name : {"a.jpg", "a.jpeg"}) {
    ASSERT_TRUE(write_image(image, folder_ / name, {}).is_ok());
    const auto read = read_image(folder_ / name);
    ASSERT_TRUE(read.is_ok()) << read.status().message();
    EXPECT_TRUE(read->is_display);
    for (std::size_t i = 0; i < smooth.size(); ++i) ASSERT_NEAR(read->rgb[i], smooth[i], 0.03f);
  }
}

TEST_F(ImageFile, AttributesComeBack) {
  WriteOptions options;
  options.attributes = {{"Software", "Tessera"}, {"tessera:camera", "0,1,2 0,0,0 0,1,0 40"}};
  for (const char* name : {"a.exr", "a.png", "a.jpg"}) {
    ASSERT_TRUE(write_image(sample_image(), folder_ / name, options).is_ok());
    const auto read = read_image(folder_ / name);
    ASSERT_TRUE(read.is_ok());
    EXPECT_EQ(read->attributes.at("Software"), "Tessera") << name;
    EXPECT_EQ(read->attributes.at("tessera:camera"), "0,1,2 0,0,0 0,1,0 40") << name;
  }
}

TEST_F(ImageFile, RowZeroIsOnTop) {
  ASSERT_TRUE(write_image(sample_image(), folder_ / "a.pfm", {}).is_ok());
  std::ifstream file(folder_ / "a.pfm", std::ios::binary);
  std::string magic;
  int width = 0, height = 0;
  float scale = 0;
  file >> magic >> width >> height >> scale;
  file.get();
  float first = -1;  // PFM begins with the bottom row
  file.read(reinterpret_cast<char*>(&first), sizeof(first));
  EXPECT_EQ(magic, "PF");
  EXPECT_LT(scale, 0) << "little-endian";
  EXPECT_EQ(first, sample_pixels()[3 * kWidth * (kHeight - 1)]);
}

TEST_F(ImageFile, AWriteThatFailsLeavesTheOldFileAndNoOther) {
  folder_.write("a.pfm", "old");
  const std::string big = folder_ / "a.pfm";
  FrameImage image = sample_image();
  const Status status = write_image(image, folder_ / "gone/a.pfm", {});
  ASSERT_FALSE(status.is_ok());
  EXPECT_NE(status.message().find("gone/a.pfm"), std::string::npos);
  EXPECT_EQ(file_count(), 1u);
  EXPECT_EQ(std::filesystem::file_size(big), 3u);
}

TEST_F(ImageFile, OverwritesInOneStep) {
  folder_.write("a.png", "old");
  EXPECT_FALSE(through("a.png").empty());
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(ImageFile, ADamagedFileIsNamed) {
  auto read = read_image(folder_.write("bad.exr", "not a picture"));
  ASSERT_FALSE(read.is_ok());
  EXPECT_NE(read.status().message().find("bad.exr"), std::string::npos);
}

}  // namespace
}  // namespace tessera::master
