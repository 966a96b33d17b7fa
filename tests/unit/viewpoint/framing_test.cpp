// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/framing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/validate.h"
#include "tests/support/box_scene.h"
#include "tests/support/small_scene.h"

namespace tessera {
namespace {

Scene points(const std::vector<Vec3f>& corners) {
  Scene scene = test::BoxScene().scene();
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = corners;
  mesh->materials = {0};
  for (std::uint32_t i = 0; i < corners.size(); ++i) mesh->triangles.push_back({i, i, i});
  scene.meshes = {mesh};
  return scene;
}

TEST(SupportMap, FarthestVertexIsFoundThroughEveryInstance) {
  const Scene scene = test::make_small_scene();
  const SupportMap map(scene);
  for (const Vec3d direction : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, -1, 0},
                                Vec3d{0, 0, 1}, Vec3d{1, -2, 3}, Vec3d{-3, 1, 0.5}}) {
    double height = -1e300;
    for (const Instance& instance : scene.instances) {
      const Mesh& mesh = *scene.meshes[instance.mesh];
      for (const auto& triangle : mesh.triangles) {
        for (const std::uint32_t v : triangle)
          height = std::max(
              height, dot(direction, widened(instance.object_to_world.point(mesh.positions[v]))));
      }
    }
    EXPECT_NEAR(dot(direction, map.farthest(direction)), height, 1e-5);
  }
}

TEST(SupportMap, VerticesOfNoTriangleDoNotCount) {
  Scene scene = test::BoxScene().box({0, 0, 0}, {1, 1, 1}, false).scene();
  auto mesh = std::make_shared<Mesh>(*scene.meshes[0]);
  mesh->positions.push_back({1000, 1000, 1000});
  scene.meshes[0] = mesh;
  EXPECT_EQ(SupportMap(scene).farthest({1, 1, 1}), (Vec3d{1, 1, 1}));
}

TEST(Framing, OfAPointEveryCameraIsValid) {
  for (const float at : {0.0f, 1e-20f, 1.0f, -1e6f, 1e15f}) {
    const Scene scene = points({{at, -at, at}});
    const Camera camera = framed_camera(SupportMap(scene), {});
    EXPECT_TRUE(validate_camera(camera).is_ok()) << at;
    EXPECT_GT(camera.eye.z, at);
  }
}

TEST(Framing, WhatHasNoExtentAcrossTheViewIsBeforeTheEye) {
  const Scene scene = points({{0, 0, -3}, {0, 0, 2}});
  const Camera camera = framed_camera(SupportMap(scene), {});
  EXPECT_EQ(camera.eye, (Vec3f{0, 0, 3}));
  EXPECT_FLOAT_EQ(camera.target.z, -0.5f);
}

// A cube of side 2 seen along an axis: its near face fills 80 % of the height, so that the eye is
// 1 / (0.8 tan 22.5 degrees) before it.
TEST(Framing, ACubeIsSeenFromTheClosedForm) {
  const Scene scene = test::BoxScene().box({-1, -1, -1}, {1, 1, 1}, false).scene();
  Framing framing;
  framing.aspect = 1.5;
  const Camera camera = framed_camera(SupportMap(scene), framing);
  EXPECT_NEAR(camera.eye.z, 1 + 1 / (0.8 * std::tan(22.5 * 3.14159265358979 / 180)), 1e-6);
  EXPECT_NEAR(camera.eye.x, 0, 1e-6);
  EXPECT_NEAR(camera.eye.y, 0, 1e-6);
  EXPECT_NEAR(camera.target.z, 0, 1e-6);
}

}  // namespace
}  // namespace tessera
