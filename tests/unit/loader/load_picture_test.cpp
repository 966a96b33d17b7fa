// SPDX-License-Identifier: Apache-2.0
// The real tessera-import decodes pictures that a person names, and stand-ins for it misbehave: the
// master gets pixels or one line, and decodes nothing itself.
#include "master/loader/load_picture.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>

#include "master/image/picture_stream.h"
#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

class Picture : public ::testing::Test {
 protected:
  void TearDown() override { unsetenv("TESSERA_IMPORT"); }

  Result<FloatImage> load(const std::string& path) {
    return load_picture(path, {}, [] { return true; });
  }
  // Runs a shell script in the place of tessera-import.
  std::string refusal_instead(const std::string& script) {
    const std::string program = folder_.write("import.sh", "#!/bin/sh\n" + script);
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    setenv("TESSERA_IMPORT", program.c_str(), 1);
    return load(pixels_).status().message();
  }

  // Two pixels, written from the bottom row up as the format has it.
  static std::string pfm() {
    const float pixels[] = {1, 2, 3, -0.5f, 0, 1e6f};
    return "PF\n2 1\n-1.0\n" + std::string(reinterpret_cast<const char*>(pixels), sizeof(pixels));
  }

  const test::TempFolder folder_;
  const std::string pixels_ = folder_.write("a.pfm", pfm());
};

TEST_F(Picture, TheImporterDecodesItToTheBit) {
  const auto image = load(pixels_);
  ASSERT_TRUE(image.is_ok()) << image.status().message();
  EXPECT_EQ(image->width_px, 2);
  EXPECT_EQ(image->height_px, 1);
  EXPECT_FALSE(image->is_display);
  EXPECT_EQ(image->rgb, (std::vector<float>{1, 2, 3, -0.5f, 0, 1e6f}));
}

TEST_F(Picture, WhatIsNoPictureIsOneLineThatNamesIt) {
  for (const char* name : {"bad.exr", "bad.png", "bad.pfm"}) {
    const std::string path = folder_.write(name, "not a picture");
    const Status status = load(path).status();
    EXPECT_NE(status.message().find(path), std::string::npos) << status.message();
    EXPECT_EQ(status.message().find('\n'), std::string::npos);
  }
  EXPECT_FALSE(load(folder_ / "gone.png").is_ok());
}

TEST_F(Picture, ADecoderThatDiesOrLiesEndsNothingElse) {
  EXPECT_NE(refusal_instead("kill -SEGV $$").find("a.pfm: the importer was ended by"),
            std::string::npos);
  EXPECT_NE(refusal_instead("echo TSPIxxxx").find("malformed"), std::string::npos);
  EXPECT_NE(refusal_instead("exit 1").find("cannot be imported"), std::string::npos);
}

TEST(PictureStream, WhatIsWrittenIsRead) {
  PictureStream stream;
  stream.image.width_px = 1;
  stream.image.height_px = 2;
  stream.image.is_display = true;
  stream.image.rgb = {1, 2, 3, 4, 5, 6};
  stream.image.attributes = {{"exposure", "2"}, {"tone", "agx"}};
  stream.warning = "without a sandbox";
  const std::vector<std::byte> bytes = encode_picture_stream(stream);
  const auto read = decode_picture_stream(bytes);
  ASSERT_TRUE(read.is_ok());
  EXPECT_EQ(read->image.rgb, stream.image.rgb);
  EXPECT_EQ(read->image.height_px, 2);
  EXPECT_TRUE(read->image.is_display);
  EXPECT_EQ(read->image.attributes, stream.image.attributes);
  EXPECT_EQ(read->warning, stream.warning);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(decode_picture_stream(std::span(bytes).first(size)).is_ok()) << size;
  std::vector<std::byte> longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(decode_picture_stream(longer).is_ok());
}

TEST(PictureStream, ASizeThatIsNotBackedByBytesIsRefusedBeforeItIsTaken) {
  PictureStream stream;
  stream.image.width_px = stream.image.height_px = 16384;  // 3 GiB, of which nothing follows
  EXPECT_FALSE(decode_picture_stream(encode_picture_stream(stream)).is_ok());
  stream.image.width_px = 0;
  EXPECT_FALSE(decode_picture_stream(encode_picture_stream(stream)).is_ok());
}

}  // namespace
}  // namespace tessera::master
