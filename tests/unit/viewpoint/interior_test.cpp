// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/interior.h"

#include <gtest/gtest.h>

#include "common/scene/validate.h"
#include "tests/support/box_scene.h"

namespace tessera {
namespace {

using test::BoxScene;

AxisRays rays_of(const Scene& scene) { return {scene, scene_bounds(scene)}; }

InteriorEvidence evidence(const BoxScene& scene) { return evidence_of(rays_of(scene.scene())); }

BoxScene room(unsigned without = 0) { return BoxScene().box({0, 0, 0}, {6, 3, 4}, true, without); }

TEST(AxisRays, DistancesAndSidesAreThoseOfABox) {
  const Scene scene = room().scene();
  const AxisRays rays = rays_of(scene);
  for (const int i : {0, 17, AxisRays::index(20, 30, 40), AxisRays::kPoints - 1}) {
    const Vec3d p = rays.point(i);
    const double expected[6] = {6 - p.x, p.x, 3 - p.y, p.y, 4 - p.z, p.z};
    for (const Axis axis : kAxes) {
      const AxisRays::Met met = rays.met(i, axis);
      EXPECT_NEAR(met.distance, expected[static_cast<int>(axis)], 1e-5);
      EXPECT_TRUE(met.is_front);
      EXPECT_FALSE(rays.met_from_outside(i, axis).is_front);
      EXPECT_NEAR(rays.met_from_outside(i, axis).distance, 0, 1e-5);
    }
  }
}

TEST(AxisRays, WhatIsInFrontHidesWhatIsBehind) {
  const AxisRays rays = rays_of(room().box({2, 1, 1}, {4, 2, 3}, false).scene());
  const int left = AxisRays::index(4, AxisRays::kSide / 2, AxisRays::kSide / 2);
  EXPECT_NEAR(rays.met(left, Axis::kRight).distance, 2 - rays.point(left).x, 1e-5);
  EXPECT_TRUE(rays.met(left, Axis::kRight).is_front);
  const int inside = AxisRays::index(AxisRays::kSide / 2, AxisRays::kSide / 2, AxisRays::kSide / 2);
  EXPECT_FALSE(rays.met(inside, Axis::kRight).is_front);
}

TEST(AxisRays, DoubleSidedSheetsAreFrontsFromBothSides) {
  Scene scene = room().scene();
  scene.materials[0].is_double_sided = true;
  const AxisRays rays = rays_of(scene);
  EXPECT_TRUE(rays.met_from_outside(0, Axis::kRight).is_front);
  EXPECT_TRUE(rays.met(0, Axis::kRight).is_front);
}

TEST(AxisRays, WithoutVolumeThereAreNone) {
  EXPECT_TRUE(rays_of(Scene{}).is_empty());
  EXPECT_TRUE(rays_of(BoxScene().box({0, 0, 0}, {1, 0, 1}, false).scene()).is_empty());
}

TEST(Interior, AClosedRoomIsOneWithWallsOfOneOrTwoSides) {
  EXPECT_TRUE(evidence(room()).is_interior());
  EXPECT_TRUE(evidence(BoxScene().house({0, 0, 0}, {6, 3, 4}, 0.2f)).is_interior());
}

TEST(Interior, ASolidIsNone) {
  EXPECT_FALSE(evidence(BoxScene().box({0, 0, 0}, {6, 3, 4}, false)).is_interior());
}

TEST(Interior, AThingAmongWhichOneSeesIsNone) {
  BoxScene scene;  // four columns on a slab
  scene.box({0, 0, 0}, {6, 0.2f, 6}, false);
  for (const float x : {0.5f, 5.0f})
    for (const float z : {0.5f, 5.0f}) scene.box({x, 0.2f, z}, {x + 0.5f, 4, z + 0.5f}, false);
  EXPECT_FALSE(evidence(scene).is_interior());
}

// A vessel's inner side is smaller than its outer, and its room is a small part of the box.
TEST(Interior, AVesselIsNone) {
  BoxScene scene;
  scene.house({1, 0, 1}, {4, 3, 4}, 0.3f).box({4, 1, 2.2f}, {6, 2, 2.8f}, false);
  EXPECT_FALSE(evidence(scene).is_interior());
}

TEST(Interior, AFloorPlanWithoutCeilingIsNone) {
  EXPECT_FALSE(evidence(room(test::kTop)).is_interior());
}

// A room stays one when its roof has a hole, as in a courtyard.
TEST(Interior, ARoofWithAHoleKeepsARoomOne) {
  BoxScene scene = room(test::kTop);
  scene.box({0, 2.9f, 0}, {6, 3, 1.5f}, false).box({0, 2.9f, 2.5f}, {6, 3, 4}, false);
  EXPECT_TRUE(evidence(scene).is_interior());
}

TEST(Interior, TheOpenSideIsTheFront) {
  const InteriorEvidence open = evidence(room(test::kFront));
  EXPECT_TRUE(open.is_interior());
  EXPECT_EQ(open.view(), Axis::kAhead);
  EXPECT_TRUE(open.is_open(Axis::kAhead));
  EXPECT_FALSE(open.is_open(Axis::kBack));
  const InteriorEvidence far = evidence(room(test::kFar));
  EXPECT_EQ(far.view(), Axis::kBack);
  EXPECT_TRUE(far.is_open(Axis::kBack));
}

// The rule by itself, just beside its limits.
TEST(Interior, SharesDecide) {
  InteriorEvidence e;
  e.room_volume = 0.51;
  EXPECT_TRUE(e.is_interior());
  e.depth[static_cast<std::size_t>(Axis::kDown)] = 0.51;
  EXPECT_FALSE(e.is_interior());
  e = {};
  e.room_volume = 0.4;
  e.room_surface = 0.49;
  EXPECT_FALSE(e.is_interior());
  e.room_surface = 0.51;
  EXPECT_TRUE(e.is_interior());
  e.room_volume = 0.3;
  EXPECT_FALSE(e.is_interior());
}

}  // namespace
}  // namespace tessera
