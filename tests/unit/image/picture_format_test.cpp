// SPDX-License-Identifier: Apache-2.0
#include "master/image/picture_format.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "master/image/picture_budget.h"
#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

std::string tga_head(char kind, char bits) {
  std::string head(18, '\0');
  head[2] = kind;
  head[12] = head[14] = 1;
  head[16] = bits;
  return head;
}

TEST(PictureFormat, IsThatOfSuffixAndContent) {
  const test::TempFolder folder;
  for (const auto& [name, content, reader] :
       {std::tuple<const char*, std::string, const char*>{"a.PNG", "\x89PNG\r\n\x1a\nx", "png"},
        {"a.jpeg", "\xff\xd8\xff\xe0", "jpeg"},
        {"a.webp", "RIFF____WEBPx", "webp"},
        {"a.exr", "\x76\x2f\x31\x01", "openexr"},
        {"a.hdr", "#?RADIANCE\n", "hdr"},
        {"a.tif", std::string("II*\0x", 5), "tiff"},
        {"a.pfm", "PF\n1 1\n", "pnm"},
        {"a.bmp", "BMxxxx", "bmp"},
        {"a.tga", tga_head(2, 24), "targa"}}) {
    const auto file = picture_format_of(folder.write(name, content));
    ASSERT_TRUE(file.is_ok()) << name << ": " << file.status().message();
    EXPECT_EQ(file->format->reader, std::string(reader));
    EXPECT_EQ(file->file_bytes, content.size());
  }
}

TEST(PictureFormat, WhatDoesNotAgreeIsRefusedAndSaysWhy) {
  const test::TempFolder folder;
  const auto refusal = [&](const char* name, const std::string& content) {
    const auto file = picture_format_of(folder.write(name, content));
    return file.is_ok() ? std::string("read") : file.status().message();
  };
  const std::string png = "\x89PNG\r\n\x1a\n";
  EXPECT_EQ(refusal("a.jpg", png), "is a PNG picture by its content; rename it to end in .png");
  EXPECT_EQ(refusal("b.png", "GIF89a"), "does not begin as a PNG picture does");
  EXPECT_EQ(refusal("c.png", ""), "does not begin as a PNG picture does");
  EXPECT_EQ(refusal("d.png", std::string(64, '\0')), "does not begin as a PNG picture does");
  EXPECT_EQ(refusal("e.tga", tga_head(4, 24)), "does not begin as a TGA picture does");
  EXPECT_EQ(refusal("f.tga", tga_head(2, 7)), "does not begin as a TGA picture does");
  for (const char* name : {"g.gif", "g", "g.psd", "g.dds", "g.png.txt", "g.", "g.jp", "g.jpg,"})
    EXPECT_TRUE(refusal(name, png).starts_with("is no picture by its suffix")) << name;
  EXPECT_TRUE(picture_format_of(folder / "gone.png").status().message().starts_with("cannot be"));
}

TEST(PictureFormat, AFileThatIsTooLargeIsNotOpened) {
  const test::TempFolder folder;
  const std::string path = folder.write("a.png", "\x89PNG\r\n\x1a\n");
  std::filesystem::resize_file(path, kPictureFileBytesMax + 1);  // sparse
  const auto file = picture_format_of(path);
  ASSERT_FALSE(file.is_ok());
  EXPECT_EQ(file.status().message(), "is larger than 1024 MiB");
}

TEST(PictureBudget, SmallFilesDoNotBecomeGigabytes) {
  PictureBudget budget;
  const std::uint64_t texels = 16384ull * 16384, zeros = 260'000;
  EXPECT_FALSE(budget.book(zeros, texels, 4 * texels).is_ok());
  EXPECT_FALSE(budget.book(2 * zeros, texels, 8 * texels).is_ok());
  // A photograph of that size passes, also behind those that were refused.
  EXPECT_TRUE(budget.book(100'000'000, texels, 4 * texels).is_ok());
}

TEST(PictureBudget, ManySmallOnesAreCountedTogether) {
  PictureBudget budget;
  const std::uint64_t texels = 4096ull * 4096;
  int taken = 0;
  while (taken < 1000 && budget.book(16'500, texels, 4 * texels).is_ok()) ++taken;
  // 64 MiB each, of which 3.3 MB are owed to the files: four fill what is free.
  EXPECT_EQ(taken, 4);
}

TEST(PictureBudget, TexelsHaveABound) {
  PictureBudget budget;
  const std::uint64_t texels = 16384ull * 16384, file = 1ull << 30;
  int taken = 0;
  while (taken < 1000 && budget.book(file, texels, 4 * texels).is_ok()) ++taken;
  EXPECT_EQ(taken, 8);
  EXPECT_TRUE(budget.book(file, 0, 0).is_ok());
  EXPECT_FALSE(budget.book(file, 1, 4).is_ok());
}

}  // namespace
}  // namespace tessera::master
