// SPDX-License-Identifier: Apache-2.0
// A new file format takes a row of the table and a file that reads it: row.inc and off.cpp. The
// registry and the importer's choice of a reader are compiled once more here, with that row.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/scene/validate.h"
#include "master/import/read_file.h"

namespace tessera::import {
namespace {

using ::testing::HasSubstr;

class ExampleFormat : public ::testing::Test {
 protected:
  ExampleFormat() { std::filesystem::create_directories(folder_); }
  ~ExampleFormat() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name, const std::string& text) const {
    const std::string path = folder_ / name;
    std::ofstream(path) << text;
    return path;
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("example_format_" + std::to_string(getpid()));
};

constexpr const char* kTriangle = "OFF\n3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

TEST_F(ExampleFormat, IsReadByItsReader) {
  const auto read = read_file(file("a.off", kTriangle));
  ASSERT_TRUE(read.is_ok()) << read.status().message();
  EXPECT_TRUE(validate_scene(read->scene).is_ok());
  EXPECT_EQ(read->scene.meshes.at(0)->triangles.size(), 1u);
}

TEST_F(ExampleFormat, IsTold) {
  EXPECT_EQ(suffix_list(false),
            ".obj, .ply, .stl, .gltf, .glb, .fbx, .dae, .bpt, .step, .stp, .iges, .igs, .off");
  EXPECT_EQ(suffix_list(true), ".hdr, .exr");
}

TEST_F(ExampleFormat, IsKnownByItsContent) {
  const auto wrong = read_file(file("a.stl", kTriangle));
  ASSERT_FALSE(wrong.is_ok());
  EXPECT_THAT(wrong.status().message(), HasSubstr("is an OFF file by its content; rename it to"));
}

TEST_F(ExampleFormat, IsRefusedWhereItIsCutShort) {
  const auto cut = read_file(file("a.off", "OFF\n3 1 3\n0 0 0\n"));
  ASSERT_FALSE(cut.is_ok());
  EXPECT_THAT(cut.status().message(), HasSubstr("a.off: is cut short"));
}

// The formats before the new one are read as they were.
TEST_F(ExampleFormat, OthersAreReadAsEver) {
  const auto read = read_file(file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  ASSERT_TRUE(read.is_ok()) << read.status().message();
  EXPECT_EQ(read->scene.meshes.at(0)->triangles.size(), 1u);
}

}  // namespace
}  // namespace tessera::import
