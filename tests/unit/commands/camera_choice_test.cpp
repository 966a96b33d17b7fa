// SPDX-License-Identifier: Apache-2.0
#include "master/commands/camera_choice.h"

#include <gtest/gtest.h>

#include "common/scene/validate.h"
#include "tests/support/box_scene.h"
#include "tests/support/temp_folder.h"

namespace tessera::master {
namespace {

Camera from(float z) { return {{0, 0, z}, {0, 0, 0}, {0, 1, 0}, 30}; }

Scene two_cameras() {
  Scene scene = test::BoxScene().box({-1, -1, -1}, {1, 1, 1}, false).scene();
  scene.cameras = {{"wide", from(5)}, {"left\nwing", from(6)}, {"1", from(7)}};
  scene.camera = from(5);
  return scene;
}

Result<Camera> chosen(const Scene& scene, const std::string& text) {
  MasterOptions options;
  options.camera = text;
  auto choice = CameraChoice::read(options);
  if (!choice.is_ok()) return choice.status();
  const Status status = choice->settle(scene, 320, 240);
  if (!status.is_ok()) return status;
  return choice->at(0);
}

TEST(CameraChoice, TakesTheFilesCamerasByNumberAndName) {
  EXPECT_EQ(chosen(two_cameras(), "2")->eye.z, 6);
  EXPECT_EQ(chosen(two_cameras(), "wide")->eye.z, 5);
  EXPECT_EQ(chosen(two_cameras(), "left\nwing")->eye.z, 6);
  EXPECT_EQ(chosen(two_cameras(), "1")->eye.z, 5) << "numbers come before names";
}

TEST(CameraChoice, KnowsWhichOfTheScenesCamerasItIs) {
  MasterOptions options;
  auto choice = CameraChoice::read(options);
  ASSERT_TRUE(choice->settle(two_cameras(), 320, 240).is_ok());
  EXPECT_EQ(choice->number_in(two_cameras()), 0u);
  options.camera = "left\nwing";
  choice = CameraChoice::read(options);
  ASSERT_TRUE(choice->settle(two_cameras(), 320, 240).is_ok());
  EXPECT_EQ(choice->number_in(two_cameras()), 1u);
  options.inline_camera = from(5);
  choice = CameraChoice::read(options);
  ASSERT_TRUE(choice->settle(two_cameras(), 320, 240).is_ok());
  EXPECT_EQ(choice->number_in(two_cameras()), std::nullopt) << "it was given by its numbers";
}

TEST(CameraChoice, AFileOfThatNameWins) {
  const test::TempFolder folder;
  const std::string path = folder.write("wide", "eye 0 0 9\ntarget 0 0 0\nsize 64 32\n");
  Scene scene = two_cameras();
  scene.cameras[0].name = path;
  EXPECT_EQ(chosen(scene, path)->eye.z, 9);
}

TEST(CameraChoice, UnknownNamesAreAnsweredWithTheListInOneLine) {
  for (const char* text : {"0", "4", "-1", "Wide", "missing.camera"}) {
    const auto camera = chosen(two_cameras(), text);
    ASSERT_FALSE(camera.is_ok()) << text;
    const std::string line = camera.status().message();
    EXPECT_NE(line.find(text), std::string::npos) << line;
    EXPECT_NE(line.find("1 'wide', 2 'left?wing', 3 '1'"), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  }
  Scene scene = two_cameras();
  scene.cameras.assign(100, {"many", from(5)});
  EXPECT_NE(chosen(scene, "x").status().message().find("and 88 more"), std::string::npos);
  scene.cameras.clear();
  scene.camera.reset();
  EXPECT_NE(chosen(scene, "x").status().message().find("no cameras"), std::string::npos);
}

TEST(CameraChoice, TheOnlyCameraOfASceneWithoutAListIsTheFirst) {
  Scene scene = two_cameras();
  scene.cameras.clear();
  EXPECT_EQ(chosen(scene, "1")->eye.z, 5);
}

TEST(CameraChoice, WithoutAnyTheSceneIsShown) {
  Scene scene = two_cameras();
  EXPECT_EQ(chosen(scene, "")->eye.z, 5);
  scene.cameras.clear();
  scene.camera.reset();
  const auto camera = chosen(scene, "");
  ASSERT_TRUE(camera.is_ok());
  EXPECT_TRUE(validate_camera(*camera).is_ok());
  EXPECT_GT(length(camera->eye), 3);
}

// --orbit turns the camera about its eye in a room, and moves it around a thing.
TEST(CameraChoice, ARoomIsTurnedAboutTheEye) {
  const Scene room = test::BoxScene().box({0, 0, 0}, {6, 3, 4}, true).scene();
  auto choice = CameraChoice::read({});
  ASSERT_TRUE(choice.is_ok() && choice->settle(room, 320, 240).is_ok());
  EXPECT_EQ(choice->orbit_centre(room), choice->at(0).eye);
  const Scene thing = test::BoxScene().box({0, 0, 0}, {6, 3, 4}, false).scene();
  ASSERT_TRUE(choice->settle(thing, 320, 240).is_ok());
  EXPECT_LT(length(choice->orbit_centre(thing) - Vec3f{3, 1.5f, 2}), 1);
}

TEST(CameraChoice, KeyFStaysInARoom) {
  const Scene room = test::BoxScene().box({0, 0, 0}, {6, 3, 4}, true).scene();
  const Camera camera = camera_of_all(room)(from(50), 1.5);
  EXPECT_TRUE(camera.eye.z > 0 && camera.eye.z < 4) << camera.eye.z;
}

}  // namespace
}  // namespace tessera::master
