// SPDX-License-Identifier: Apache-2.0
#include "master/loader/file_watch.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

FileLook look(std::uint64_t bytes, std::int64_t seconds) { return {1, 2, bytes, seconds, 0}; }

TEST(FileWatch, WhatStaysTheSameIsNoChange) {
  FileWatch watch(look(10, 100));
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(watch.is_changed(look(10, 100)));
}

TEST(FileWatch, AChangeIsToldOnceItHasSettled) {
  FileWatch watch(look(10, 100));
  EXPECT_FALSE(watch.is_changed(look(5, 101))) << "it may still be written";
  EXPECT_FALSE(watch.is_changed(look(12, 102)));
  EXPECT_TRUE(watch.is_changed(look(12, 102)));
  EXPECT_FALSE(watch.is_changed(look(12, 102))) << "once";
  EXPECT_FALSE(watch.is_changed(look(12, 103)));
  EXPECT_TRUE(watch.is_changed(look(12, 103))) << "equal sizes, another time";
}

TEST(FileWatch, AFileThatIsGoneForAMomentIsNoChange) {
  FileWatch watch(look(10, 100));
  EXPECT_FALSE(watch.is_changed(std::nullopt));
  EXPECT_FALSE(watch.is_changed(look(10, 100)));
  EXPECT_FALSE(watch.is_changed(look(10, 100)));
  EXPECT_FALSE(watch.is_changed(std::nullopt));
  EXPECT_TRUE(watch.is_changed(std::nullopt)) << "gone for good is told";
}

TEST(FileWatch, ALookSeesAnotherFileOfTheSameSizeInItsPlace) {
  const test::TempFolder folder;
  const std::string path = folder / "scene.obj";
  EXPECT_FALSE(look_at_file(path).has_value());
  std::ofstream(path) << "v 0 0 0\n";
  const auto first = look_at_file(path);
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(look_at_file(path), first);
  std::ofstream(path + ".new") << "v 1 1 1\n";
  std::filesystem::last_write_time(path + ".new", std::filesystem::last_write_time(path));
  std::filesystem::rename(path + ".new", path);
  EXPECT_NE(look_at_file(path), first);
}

}  // namespace
}  // namespace tessera::master
