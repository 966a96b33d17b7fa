// SPDX-License-Identifier: Apache-2.0
#include "common/scene_io/camera_file.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include "common/scene/validate.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace tessera {
namespace {

TEST(CameraFile, OneCameraWithSize) {
  const test::TempFolder folder;
  auto path = read_camera_file(folder.write(
      "a.camera",
      "# a comment\neye 1 2 3\nat 0 0 -1\nup 0 0 1\r\nfov 30\nsize 320 200\nlight 1 1 1\n"));
  ASSERT_TRUE(path.is_ok()) << path.status().message();
  const Camera camera = path->at(17);
  EXPECT_EQ(camera.eye, (Vec3f{1, 2, 3}));
  EXPECT_EQ(camera.target, (Vec3f{0, 0, -1}));
  EXPECT_EQ(camera.vfov_degrees, 30);
  ASSERT_TRUE(path->size().has_value());
  EXPECT_EQ(path->size()->width_px, 320);
}

TEST(CameraFile, FramesAreInterpolatedSmoothlyAndHeldOutside) {
  const test::TempFolder folder;
  auto path =
      read_camera_file(folder.write("p.camera",
                                    "target 0 0 0\nframe 10\neye 0 0 5\nframe 20\neye 2 0 5\n"
                                    "frame 30\neye 2 2 5\n"));
  ASSERT_TRUE(path.is_ok()) << path.status().message();
  EXPECT_EQ(path->at(0).eye, path->at(10).eye);
  EXPECT_EQ(path->at(99).eye, (Vec3f{2, 2, 5}));
  EXPECT_EQ(path->at(20).eye, (Vec3f{2, 0, 5}));
  for (double frame = 10; frame < 30; frame += 0.25) {  // no jumps, also at the keys
    EXPECT_LT(length(path->at(frame + 0.25).eye - path->at(frame).eye), 0.1f) << frame;
  }
}

TEST(CameraFile, WhatIsWrongIsNamedWithItsLine) {
  const struct {
    const char *text, *said;
  } cases[] = {{"eye 0 0 5\nlens 3\n", ":2: unknown key 'lens'"},
               {"eye 0 0\n", ":1: "},
               {"eye 0 0 5 6\n", ":1: "},
               {"fov wide\n", ":1: "},
               {"size 0 10\n", ":1: "},
               {"frame 3\nframe 3\n", ":2: "},
               {"frame -1\n", ":1: "},
               {"eye 0 0 0\ntarget 0 0 0\n", "same point"},
               {"eye 0 0 nan\n", "finite"}};
  const test::TempFolder folder;
  for (const auto& c : cases) {
    auto path = read_camera_file(folder.write("x.camera", c.text));
    ASSERT_FALSE(path.is_ok()) << c.text;
    EXPECT_NE(path.status().message().find(c.said), std::string::npos) << path.status().message();
  }
  EXPECT_FALSE(read_camera_file(folder / "gone.camera").is_ok());
}

TEST(CameraText, TenNumbersInFourGroups) {
  auto camera = parse_camera_text("1,2,3 4,5,6 0,1,0 50");
  ASSERT_TRUE(camera.is_ok());
  EXPECT_EQ(camera->target, (Vec3f{4, 5, 6}));
  EXPECT_EQ(camera->vfov_degrees, 50);
  EXPECT_FALSE(parse_camera_text("1,2,3 4,5,6 0,1,0").is_ok());
  EXPECT_FALSE(parse_camera_text("1,2,3 4,5,6 0,1,0 50 60").is_ok());
  EXPECT_FALSE(parse_camera_text("").is_ok());
}

// `render --camera` reads the text that the window copies as the same camera, to the last bit.
TEST(CameraText, IsReadAsTheSameCamera) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  std::mt19937 random(seed);
  const auto any = [&random] {  // any finite float, of any magnitude
    while (true) {
      const float value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
      // Only floats of a magnitude that validate_camera() can square.
      if (std::isfinite(value) && std::abs(value) < 1e15f && std::abs(value) > 1e-15f) return value;
    }
  };
  int read = 0;
  for (int i = 0; i < 20'000; ++i) {
    Camera camera;
    camera.eye = {any(), any(), any()};
    camera.target = {any(), any(), any()};
    camera.up = {any(), any(), any()};
    camera.vfov_degrees = std::uniform_real_distribution<float>(1, 179)(random);
    if (!validate_camera(camera).is_ok()) continue;
    const auto again = parse_camera_text(camera_text(camera));
    ASSERT_TRUE(again.is_ok()) << camera_text(camera) << ": " << again.status().message();
    ASSERT_EQ(std::memcmp(&*again, &camera, sizeof(camera)), 0) << camera_text(camera);
    ++read;
  }
  EXPECT_GT(read, 2'000);
  EXPECT_EQ(camera_text({{0.1f, -2, 1e-20f}, {0, 0, 0}, {0, 1, 0}, 58}),
            "0.1,-2,1e-20 0,0,0 0,1,0 58");
}

}  // namespace
}  // namespace tessera
