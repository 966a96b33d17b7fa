// SPDX-License-Identifier: Apache-2.0
#include "common/viewpoint/inside_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/scene/validate.h"
#include "tests/support/box_scene.h"

namespace tessera {
namespace {

using test::BoxScene;

AxisRays rays_of(const Scene& scene) { return {scene, scene_bounds(scene)}; }

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A place in an empty room [0, length] x [0, height] x [0, width] with the eye at half its height.
EyePlace place_in_hall(double x, double z, double length, double width, double height) {
  EyePlace place;
  place.eye.from = {x, height / 2, z};
  place.below.from = {x, height / 4, z};
  place.above_floor = place.below_ceiling = height / 2;
  for (int i = 0; i < kSights; ++i) {
    const Vec3d d = sight_direction(i);
    const double to_x = d.x > 0 ? (length - x) / d.x : d.x < 0 ? -x / d.x : kInfinity;
    const double to_z = d.z > 0 ? (width - z) / d.z : d.z < 0 ? -z / d.z : kInfinity;
    place.eye.distance[static_cast<std::size_t>(i)] = std::min(to_x, to_z);
  }
  place.below.distance = place.eye.distance;
  return place;
}

TEST(InsideCamera, StandsAtOneEndAndLooksAlongTheHall) {
  std::vector<EyePlace> places;
  for (double x = 0.5; x < 20; x += 0.5)
    for (double z = 0.5; z < 4; z += 0.5) places.push_back(place_in_hall(x, z, 20, 4, 3));
  const Camera camera = inside_camera(places, kInsideVfovDegrees, 4.0 / 3);
  ASSERT_TRUE(validate_camera(camera).is_ok());
  const Vec3f view = normalize(camera.target - camera.eye);
  EXPECT_GT(std::abs(view.x), 0.9f);
  EXPECT_EQ(view.y, 0);
  EXPECT_TRUE(view.x > 0 ? camera.eye.x < 2 : camera.eye.x > 18) << camera.eye.x;
}

TEST(InsideCamera, TurningAboutTheTargetStaysInTheRoom) {
  std::vector<EyePlace> places;
  for (double x = 0.5; x < 9; x += 0.5) places.push_back(place_in_hall(x, 1, 9, 2.5, 3));
  const Camera camera = inside_camera(places, kInsideVfovDegrees, 1);
  const float reach = 2 * length(camera.target - camera.eye);
  EXPECT_GE(camera.eye.x - reach, 0);
  EXPECT_LE(camera.eye.x + reach, 9);
  EXPECT_GE(camera.eye.z - reach, 0);
  EXPECT_LE(camera.eye.z + reach, 2.5f);
  EXPECT_GE(camera.eye.y - reach, 0);
}

TEST(InsideCamera, DoesNotStandInACornerNorLookOutOfTheScene) {
  std::vector<EyePlace> places{place_in_hall(0.05, 2, 8, 4, 2), place_in_hall(1, 2, 8, 4, 2),
                               place_in_hall(7, 2, 8, 4, 2)};
  for (EyePlace& place : places) {  // the end at x = 8 is open
    for (int i = 0; i < kSights; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Vec3d end = place.eye.from + place.eye.distance[at] * sight_direction(i);
      if (end.x > 7.999) place.eye.distance[at] = place.below.distance[at] = kInfinity;
    }
  }
  const Camera camera = inside_camera(places, kInsideVfovDegrees, 1);
  EXPECT_EQ(camera.eye.x, 7);
  EXPECT_LT(camera.target.x, 7);
}

TEST(InsideCamera, OfTwoHallsTheHigherIsShown) {
  const std::vector<EyePlace> places{place_in_hall(1, 2, 20, 4, 3), place_in_hall(1, 2, 20, 4, 9)};
  EXPECT_EQ(inside_camera(places, kInsideVfovDegrees, 1).eye.y, 4.5f);
}

// A table of half the eye's height stands before one of the places.
TEST(InsideCamera, ThingsBelowTheEyeHideARoomToo) {
  std::vector<EyePlace> places{place_in_hall(1, 2, 8, 4, 2), place_in_hall(7, 2, 8, 4, 2)};
  for (int i = 0; i < kSights; ++i) {
    if (sight_direction(i).x > 0) places[0].below.distance[static_cast<std::size_t>(i)] = 0.6;
  }
  EXPECT_EQ(inside_camera(places, kInsideVfovDegrees, 1).eye.x, 7);
}

TEST(EyePlaces, AreHalfwayUpARoomLowerThanWide) {
  const Scene scene = BoxScene().box({0, 10, 0}, {8, 12.5f, 5}, true).scene();
  const std::vector<EyePlace> places = eye_places(rays_of(scene));
  ASSERT_FALSE(places.empty());
  EXPECT_LE(places.size(), kEyePlacesMax);
  for (const EyePlace& place : places) {
    EXPECT_NEAR(place.eye.from.y, 11.25, 1e-5);
    EXPECT_NEAR(place.above_floor, 1.25, 1e-5);
    EXPECT_NEAR(place.below_ceiling, 1.25, 1e-5);
  }
}

TEST(EyePlaces, InATowerAreAtHalfItsWidth) {
  const Scene scene = BoxScene().box({0, 0, 0}, {4, 30, 3}, true).scene();
  for (const EyePlace& place : eye_places(rays_of(scene)))
    EXPECT_NEAR(place.above_floor, 1.5, 1e-5);
}

TEST(EyePlaces, AreNoneInSolids) {
  EXPECT_TRUE(eye_places(rays_of(BoxScene().box({0, 0, 0}, {1, 1, 1}, false).scene())).empty());
}

TEST(MeasureSights, SeesWallsAndWhatStandsBeforeThem) {
  BoxScene room;
  room.box({0, 0, 0}, {6, 3, 4}, true).box({4, 0, 1}, {5, 3, 3}, false);  // a pillar
  const Scene scene = room.scene();
  std::vector<EyePlace> places(1);
  places[0].eye.from = {1, 1.5, 2};
  places[0].below.from = {1, 0.75, 2};
  measure_sights(scene, places);
  for (int i = 0; i < kSights; ++i) {
    const Vec3d d = sight_direction(i);
    double expected = std::min(d.x != 0 ? (d.x > 0 ? 5 : -1) / d.x : kInfinity,
                               d.z != 0 ? (d.z > 0 ? 2 : -2) / d.z : kInfinity);
    const double to_pillar = d.x > 0 ? 3 / d.x : kInfinity;
    if (std::abs(to_pillar * d.z) <= 1) expected = std::min(expected, to_pillar);
    EXPECT_NEAR(places[0].eye.distance[static_cast<std::size_t>(i)], expected, 1e-9) << i;
    EXPECT_NEAR(places[0].below.distance[static_cast<std::size_t>(i)], expected, 1e-9) << i;
  }
}

TEST(MeasureSights, LeaveWhereNothingIs) {
  std::vector<EyePlace> places(1);
  places[0].eye.from = {3, 1.5, 2};
  measure_sights(BoxScene().box({0, 0, 0}, {6, 3, 4}, true, test::kFront).scene(), places);
  EXPECT_EQ(places[0].eye.distance[kSights / 2], kInfinity);
  EXPECT_NEAR(places[0].eye.distance[0], 2, 1e-9);
}

}  // namespace
}  // namespace tessera
