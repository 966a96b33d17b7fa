// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/scene_overview.h"

#include <gtest/gtest.h>

#include "common/scene/validate.h"
#include "master/loader/load_scene.h"
#include "tests/support/box_scene.h"

namespace tessera {
namespace {

using test::BoxScene;

bool is_within(const Bounds3f& box, Vec3f p) {
  return p.x > box.lower.x && p.x < box.upper.x && p.y > box.lower.y && p.y < box.upper.y &&
         p.z > box.lower.z && p.z < box.upper.z;
}

Scene builtin(const char* name) {
  auto loaded = master::make_builtin(name);
  EXPECT_TRUE(loaded.is_ok());
  return loaded->scene;
}

TEST(SceneOverview, ClosedRoomsAreShownFromWithinAndThingsFromOutside) {
  for (const auto& [name, is_inside] :
       {std::pair("room", true), std::pair("evening", true), std::pair("cornell", false),
        std::pair("teapot", false), std::pair("teapot-mesh", false), std::pair("waves", false)}) {
    const Scene scene = builtin(name);
    const SceneOverview overview(scene);
    const Camera camera = overview.default_camera(4.0 / 3);
    EXPECT_TRUE(validate_camera(camera).is_ok()) << name;
    EXPECT_EQ(overview.is_inside(), is_inside) << name;
    EXPECT_EQ(is_within(scene_bounds(scene), camera.eye), is_inside) << name;
  }
}

// The box is open at -z.
TEST(SceneOverview, TheCornellBoxIsLookedIntoStraightFromItsOpenSide) {
  const Scene scene = builtin("cornell");
  const Camera camera = default_camera(scene, 320, 240);
  const Vec3f view = normalize(camera.target - camera.eye);
  EXPECT_LT(camera.eye.z, 0);
  EXPECT_NEAR(view.z, 1, 1e-6);
}

TEST(SceneOverview, AllOfAClosedRoomIsSeenFromWithinWhereverOneStands) {
  const Scene scene = BoxScene().house({0, 0, 0}, {8, 3, 5}, 0.2f).scene();
  const SceneOverview overview(scene);
  for (const Vec3f eye : {Vec3f{1, 1, 1}, Vec3f{4, 1, 30}, Vec3f{4, 40, 2}, Vec3f{-9, 1, 2}}) {
    const Camera seen{eye, {4, 1.5f, 2.5f}, {0, 1, 0}, 35};
    const Camera camera = overview.camera_of_all(seen, 1.5);
    EXPECT_TRUE(is_within(scene_bounds(scene), camera.eye)) << eye.x;
    EXPECT_EQ(camera.vfov_degrees, 35);
  }
}

TEST(SceneOverview, AnOpenSideIsLookedThroughByWhoStandsBeforeIt) {
  const Scene scene = BoxScene().house({0, 0, 0}, {8, 3, 5}, 0.2f, test::kRight).scene();
  const SceneOverview overview(scene);
  EXPECT_TRUE(overview.is_inside());  // the front of the house is a wall
  const Camera before{{30, 1, 2}, {4, 1.5f, 2.5f}, {0, 1, 0}, 35};
  EXPECT_GT(overview.camera_of_all(before, 1).eye.x, 8);
  const Camera behind{{-30, 1, 2}, {4, 1.5f, 2.5f}, {0, 1, 0}, 35};
  EXPECT_TRUE(is_within(scene_bounds(scene), overview.camera_of_all(behind, 1).eye));
}

TEST(SceneOverview, AllOfAThingIsSeenFromTheSameDirection) {
  const SceneOverview overview(BoxScene().box({-1, -1, -1}, {1, 1, 1}, false).scene());
  const Camera seen{{5, 0, 0}, {4, 0, 0}, {0, 0, 1}, 20};
  const Camera camera = overview.camera_of_all(seen, 1);
  const Vec3f view = normalize(camera.target - camera.eye);
  EXPECT_NEAR(view.x, -1, 1e-6);
  EXPECT_EQ(camera.up, seen.up);
  EXPECT_EQ(camera.vfov_degrees, 20);
  EXPECT_GT(camera.eye.x, 1);
}

// Seen from nearer the front, the cube would look like a square.
TEST(SceneOverview, OfACubeThreeSidesAreSeen) {
  const SceneOverview overview(BoxScene().box({-1, -1, -1}, {1, 1, 1}, false).scene());
  const Vec3f eye = overview.default_camera(4.0 / 3).eye;
  EXPECT_GT(eye.x, 1.2f);
  EXPECT_GT(eye.y, 1.1f);
  EXPECT_GT(eye.z, eye.x);
}

TEST(SceneOverview, ScenesThatAreNothingOrAPointHaveACamera) {
  EXPECT_TRUE(validate_camera(default_camera(Scene{}, 64, 64)).is_ok());
  const Scene flat = BoxScene().box({0, 0, 0}, {1, 0, 1}, false).scene();
  EXPECT_TRUE(validate_camera(default_camera(flat, 64, 64)).is_ok());
  const Scene point = BoxScene().box({7, 7, 7}, {7, 7, 7}, false).scene();
  EXPECT_TRUE(validate_camera(default_camera(point, 64, 64)).is_ok());
}

}  // namespace
}  // namespace tessera
