// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "common/scene/validate.h"
#include "common/scene_io/scene_reader.h"
#include "tests/support/temp_folder.h"

namespace tessera {
namespace {

std::string head(const std::string& format, int vertices, int faces, const std::string& more = "") {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex " +
         std::to_string(vertices) + "\nproperty float x\nproperty double y\nproperty float z\n" +
         more + "element face " + std::to_string(faces) +
         "\nproperty uchar flags\nproperty list uchar int vertex_indices\nend_header\n";
}

template <typename T>
void put(std::string& out, T value, bool is_big) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  if (is_big) std::reverse(bytes, bytes + sizeof(T));
  out.append(bytes, sizeof(T));
}

std::string binary(bool is_big) {
  std::string text = head(is_big ? "binary_big_endian" : "binary_little_endian", 4, 2);
  const float points[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  for (const auto& p : points) {
    put(text, p[0], is_big);
    put(text, static_cast<double>(p[1]), is_big);
    put(text, p[2], is_big);
  }
  for (const std::vector<std::int32_t>& face : {std::vector<std::int32_t>{0, 1, 2, 3}, {3, 2, 0}}) {
    put(text, std::uint8_t{7}, is_big);
    put(text, static_cast<std::uint8_t>(face.size()), is_big);
    for (const std::int32_t index : face) put(text, index, is_big);
  }
  return text;
}

const char* const kAscii = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n7 4 0 1 2 3\n7 3 3 2 0\n";

class PlyReader : public ::testing::Test {
 protected:
  Result<ReadScene> read(const std::string& bytes) {
    return read_ply(folder_.write("a.ply", bytes));
  }
  const test::TempFolder folder_;
};

TEST_F(PlyReader, AsciiAndBothByteOrdersGiveTheSameMesh) {
  auto ascii = read(head("ascii", 4, 2) + kAscii);
  ASSERT_TRUE(ascii.is_ok()) << ascii.status().message();
  ASSERT_TRUE(validate_scene(ascii->scene).is_ok());
  ASSERT_EQ(ascii->scene.triangle_count(), 3u);
  for (const bool is_big : {false, true}) {
    auto scene = read(binary(is_big));
    ASSERT_TRUE(scene.is_ok()) << scene.status().message();
    EXPECT_EQ(*scene->scene.meshes[0], *ascii->scene.meshes[0]);
  }
}

TEST_F(PlyReader, EveryTruncationIsRefused) {
  for (const bool is_big : {false, true}) {
    const std::string whole = binary(is_big);
    for (std::size_t length = 0; length < whole.size(); ++length) {
      EXPECT_FALSE(read(whole.substr(0, length)).is_ok()) << length;
    }
  }
  const std::string text = head("ascii", 4, 2) + kAscii;
  for (std::size_t length = 0; length + 2 < text.size(); ++length) {
    EXPECT_FALSE(read(text.substr(0, length)).is_ok()) << length;
  }
}

TEST_F(PlyReader, WhatCannotBeAMeshIsRefused) {
  const struct {
    std::string text, said;
  } cases[] = {{head("ascii", 4, 1) + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n7 3 0 1 4\n", "face 0"},
               {head("ascii", 4, 1) + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n7 3 0 1 -1\n", "face 0"},
               {head("ascii", 4, 1) + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n7 2 0 1\n", "face 0"},
               {head("ascii", 4, 1) + "0 0 0\n1 0 0\n1 nan 0\n0 1 0\n7 3 0 1 2\n", "vertex 2"},
               {head("ascii", 2000000000, 1) + "0 0 0\n", "2000000000"},
               {head("utf8", 4, 2) + kAscii, "utf8"},
               {"plyx\n", "'ply'"},
               {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", ""},
               {"ply\nformat ascii 1.0\nend_header\n", ""},
               {head("ascii", 0, 0), ""}};
  for (const auto& c : cases) {
    auto scene = read(c.text);
    ASSERT_FALSE(scene.is_ok()) << c.text;
    EXPECT_NE(scene.status().message().find(c.said), std::string::npos) << scene.status().message();
  }
}

TEST_F(PlyReader, OtherElementsAreSkipped) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement camera 1\nproperty float a\nelement vertex 3\nproperty float "
      "x\n"
      "property float y\nproperty float z\nproperty uchar red\nelement edge 1\nproperty int a\n"
      "element face 1\nproperty list uchar uint vertex_index\nend_header\n"
      "5\n0 0 0 255\n1 0 0 255\n0 1 0 255\n3\n3 0 1 2\n";
  auto scene = read(text);
  ASSERT_TRUE(scene.is_ok()) << scene.status().message();
  EXPECT_EQ(scene->scene.triangle_count(), 1u);
}

}  // namespace
}  // namespace tessera
