// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "master/image/image_file.h"
#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

TEST(OutputPattern, NumbersAreFilledIn) {
  const test::TempFolder folder;
  auto many = OutputPattern::parse(folder / "a-%04d.png", true);
  ASSERT_TRUE(many.is_ok()) << many.status().message();
  EXPECT_EQ(many->path(7), folder / "a-0007.png");
  EXPECT_EQ(many->path(123456), folder / "a-123456.png");
  auto one = OutputPattern::parse(folder / "a.exr", false);
  ASSERT_TRUE(one.is_ok());
  EXPECT_EQ(one->path(7), folder / "a.exr");
}

TEST(OutputPattern, WhatCouldSurpriseIsRefused) {
  const test::TempFolder folder;
  for (const char* name :
       {"a.tga", "a", "a.png.", ".png%04d", "a%s.png", "a%d%d.png", "a%04d%04d.png", "a%%.png",
        "a%-4d.png", "a%99999999d.png", "a%4x.png", "a%.png", "a%0"}) {
    EXPECT_FALSE(OutputPattern::parse(folder / name, false).is_ok()) << name;
  }
  EXPECT_FALSE(OutputPattern::parse(folder / "a.png", true).is_ok()) << "several frames, one name";
  EXPECT_FALSE(OutputPattern::parse(folder / "gone/a.png", false).is_ok());
}

}  // namespace
}  // namespace tessera::master
