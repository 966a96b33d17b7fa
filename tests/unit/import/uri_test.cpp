// SPDX-License-Identifier: Apache-2.0
// The URIs of glTF files: what they stand for, and that they stay below the scene's folder.
#include "master/import/gltf/uri.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/temp_folder.h"

namespace tessera::import {
namespace {

TEST(Uri, PercentSignsAndBase64AreDecoded) {
  EXPECT_EQ(*percent_decoded("a%20b%2Fc"), "a b/c");
  EXPECT_FALSE(percent_decoded("a%2").is_ok());
  EXPECT_FALSE(percent_decoded("a%zz").is_ok());
  EXPECT_EQ(*base64_decoded("AQID"), std::string("\1\2\3"));
  EXPECT_EQ(*base64_decoded("AQI="), std::string("\1\2"));
  EXPECT_EQ(*base64_decoded("-_8"), *base64_decoded("+/8="));
  EXPECT_FALSE(base64_decoded("A*").is_ok());
}

TEST(Uri, OnlyFilesBelowTheFolderAreRead) {
  const test::TempFolder folder;
  std::filesystem::create_directories(folder / "scene/part");
  folder.write("outside.bin", "secret");
  folder.write("scene/a b.bin", "inside");
  folder.write("scene/part/100%.bin", "as written");
  std::filesystem::create_symlink(folder / "outside.bin", folder / "scene/link.bin");
  const auto read = [&](const std::string& uri) { return read_uri(folder / "scene", uri, 1000); };
  EXPECT_EQ(*read("a%20b.bin"), "inside");
  EXPECT_EQ(*read("a b.bin"), "inside");
  EXPECT_EQ(*read("part/100%25.bin"), "as written");
  EXPECT_EQ(*read("data:application/octet-stream;base64,AQI="), std::string("\1\2"));
  EXPECT_EQ(*read("data:,x%20y"), "x y");
  for (const char* uri :
       {"../outside.bin", "%2e%2e/outside.bin", "link.bin", "/etc/hostname", "file:///etc/hostname",
        "https://example.org/a.bin", "part", "gone.bin", "a%00.bin", "", "data:"}) {
    EXPECT_FALSE(read(uri).is_ok()) << uri;
  }
  EXPECT_FALSE(read_uri(folder / "scene", "a%20b.bin", 3).is_ok()) << "larger than the limit";
}

}  // namespace
}  // namespace tessera::import
