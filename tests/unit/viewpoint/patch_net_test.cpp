// SPDX-License-Identifier: Apache-2.0
// Cameras of freeform surfaces: whole, near, and from within where they are a room.
#include "common/viewpoint/patch_net.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/scene/validate.h"
#include "common/viewpoint/scene_overview.h"
#include "tests/support/seed.h"
#include "tests/support/surface_scene.h"

namespace tessera {
namespace {

Scene scene_of(PatchSurface surface) {
  Scene scene;
  scene.materials.resize(1);
  scene.surfaces = {std::make_shared<const PatchSurface>(std::move(surface))};
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}};
  return scene;
}

// The unit sphere as eight rational patches: a quarter turn of half a meridian each.
PatchSurface sphere() {
  const float w[3] = {1, std::sqrt(0.5f), 1};
  PatchSurface surface;
  surface.materials = {0};
  for (int turn = 0; turn < 4; ++turn) {
    for (const float side : {-1.0f, 1.0f}) {
      surface.patches.push_back({2, 2, 1, 0});
      const float x[3] = {1, 1, 0}, y[3] = {0, 1, 1};
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          float a = y[j] * x[i], b = y[j] * y[i];
          for (int k = 0; k < turn; ++k) std::swap(a, b), a = -a;
          surface.numbers.insert(surface.numbers.end(), {a, b, side * x[j], w[i] * w[j]});
        }
      }
    }
  }
  return surface;
}

// A parallelogram with corners a, a + u, a + u + v, a + v; its normal is along u x v.
void add_plate(PatchSurface& surface, Vec3f a, Vec3f u, Vec3f v) {
  surface.patches.push_back({1, 1, 0, 0});
  for (const Vec3f p : {a, a + v, a + u, a + u + v})
    surface.numbers.insert(surface.numbers.end(), {p.x, p.y, p.z});
}

// A room of 8 x 3 x 5 whose six walls look inward; the last one is that at +z.
PatchSurface room() {
  const Vec3f x{8, 0, 0}, y{0, 3, 0}, z{0, 0, 5}, o{};
  PatchSurface surface;
  surface.materials = {0};
  add_plate(surface, o, z, x);  // floor
  add_plate(surface, y, x, z);  // ceiling
  add_plate(surface, o, y, z);  // at x = 0
  add_plate(surface, x, z, y);  // at x = 8
  add_plate(surface, o, x, y);  // at z = 0
  add_plate(surface, z, y, x);  // at z = 5
  return surface;
}

// Point (u, v) of a patch as it is defined: Bernstein's polynomials from binomials.
Vec3d point_at(const PatchCursor& patch, double u, double v) {
  const auto bernstein = [](int n, int i, double t) {
    return std::exp(std::lgamma(n + 1) - std::lgamma(i + 1) - std::lgamma(n - i + 1)) *
           std::pow(t, i) * std::pow(1 - t, n - i);
  };
  const int m = patch.form().degree_u, n = patch.form().degree_v;
  Vec3d sum;
  double weights = 0;
  for (int i = 0; i <= m; ++i) {
    for (int j = 0; j <= n; ++j) {
      const auto number = static_cast<std::size_t>((n + 1) * i + j);
      const double w = patch.weight(number) * bernstein(m, i, u) * bernstein(n, j, v);
      sum = sum + w * widened(patch.point(number));
      weights += w;
    }
  }
  return (1 / weights) * sum;
}

TEST(PatchNet, TheSurfaceLiesInTheHullOfItsNet) {
  std::mt19937 random(test::seed(20261127));
  std::uniform_real_distribution<double> unit(0, 1), side(-1, 1);
  for (int n = 0; n < 60; ++n) {
    SCOPED_TRACE("surface " + std::to_string(n));
    PatchSurface surface = test::make_random_surface(random, 4);
    surface.loop_counts = surface.segment_counts = {};
    surface.degrees = {};
    surface.trim_points = {};
    surface.trim_widths = {};
    const Scene scene = scene_of(surface);
    const SupportMap map(scene);
    for (int k = 0; k < 20; ++k) {
      const Vec3d direction = normalize(Vec3d{side(random), side(random), side(random)});
      const double reach = dot(direction, map.farthest(direction));
      for (PatchCursor patch(*scene.surfaces[0]); patch.is_any(); patch.advance()) {
        const Vec3d p = point_at(patch, unit(random), unit(random));
        // Coordinates are below 100; each of the net is rounded to float once.
        EXPECT_LE(dot(direction, p), reach + 3 * 100 * 0x1p-24);
      }
    }
  }
}

TEST(PatchNet, MeshesAndSurfacesOfOneSceneAreFramedTogether) {
  Scene scene = test::make_small_scene();
  const Bounds3f before = SupportMap(scene).bounds();
  scene.surfaces = scene_of(sphere()).surfaces;
  Transform away;
  away.m[0][3] = 20;
  scene.instances.push_back({0, away, ObjectKind::kPatchSurface});
  const Bounds3f bounds = SupportMap(scene).bounds();
  EXPECT_EQ(bounds.lower.y, before.lower.y);
  EXPECT_EQ(bounds.upper.z, before.upper.z);
  EXPECT_NEAR(bounds.upper.x, 21, 1e-5);
  EXPECT_NEAR(bounds.lower.z, -1, 1e-5);
}

// From distance d the outline of the unit sphere lies at the angle whose sine is 1 / d.
TEST(PatchNet, ASphereIsFramedByItsOutline) {
  const SupportMap map(scene_of(sphere()));
  for (const Vec3d view : {Vec3d{0, 0, -1}, Vec3d{1, 0.3, -0.5}, Vec3d{-1, -1, 1}}) {
    Framing framing;
    framing.view = view;
    framing.up = {0.1, 1, 0};
    const Camera camera = framed_camera(map, framing);
    const double k = kFramedShare * std::tan(framing.vfov_degrees * std::numbers::pi / 360);
    const double distance = std::sqrt(1 + 1 / (k * k));
    const double framed = length(widened(camera.eye));
    EXPECT_GE(framed, distance * (1 - 1e-6));
    // A quarter of a circle cut into 16 has a net 1 / cos(pi / 64) as large.
    EXPECT_LE(framed, distance * 1.0025);
  }
}

TEST(PatchNet, WhatTheLoopsEnclosePartlyIsFramedByTheirBox) {
  PatchSurface plate;
  plate.materials = {0};
  add_plate(plate, {-10, -10, 0}, {20, 0, 0}, {0, 20, 0});
  plate.loop_counts = {1};
  plate.segment_counts = {3};
  plate.degrees = {1, 2, 1};
  plate.trim_points = {{0.25f, 0.5f, 1}, {0.75f, 0.5f, 1}, {0.75f, 0.625f, 2}, {0.5f, 0.75f, 1}};
  const Bounds3f inside = SupportMap(scene_of(plate)).bounds();
  EXPECT_LT(length(inside.lower - Vec3f{-5, 0, 0}), 1e-6f);
  EXPECT_LT(length(inside.upper - Vec3f{5, 5, 0}), 1e-6f);
  plate.patches[0].keeps_outside = 1;
  EXPECT_EQ(SupportMap(scene_of(plate)).bounds().upper, (Vec3f{10, 10, 0}));
}

TEST(PatchNet, MeshesThatStandForSurfacesLieOnThem) {
  Scene scene = test::make_small_scene();
  scene.surfaces = scene_of(sphere()).surfaces;
  scene.instances.push_back({0, scene.instances[1].object_to_world, ObjectKind::kPatchSurface});
  const Scene meshes = with_meshes_for_surfaces(scene);
  ASSERT_TRUE(validate_scene(meshes).is_ok());
  EXPECT_TRUE(meshes.surfaces.empty());
  ASSERT_EQ(meshes.meshes.size(), 3u);
  EXPECT_EQ(meshes.meshes[1], scene.meshes[1]) << "meshes are shared";
  EXPECT_EQ(meshes.instances.back().mesh, 2u);
  EXPECT_EQ(meshes.instances.back().object_to_world, scene.instances.back().object_to_world);
  const Mesh& ball = *meshes.meshes[2];
  EXPECT_EQ(ball.triangles.size(), 8 * 8 * 8 * 2u);
  double volume = 0;
  for (const Vec3f p : ball.positions) EXPECT_NEAR(length(widened(p)), 1, 1e-6);
  for (const auto& t : ball.triangles) {
    volume +=
        std::abs(dot(ball.positions[t[0]], cross(ball.positions[t[1]], ball.positions[t[2]]))) / 6;
  }
  // Flat cells of an eighth of a right angle leave 1.6 % of the ball outside.
  EXPECT_NEAR(volume, 4 * std::numbers::pi / 3, 0.02 * 4 * std::numbers::pi / 3);
}

// Normals of cells are those of the patch, and middles that are trimmed away have none.
TEST(PatchNet, CellsFollowTheLoops) {
  PatchSurface plate;
  plate.materials = {0};
  add_plate(plate, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  plate.loop_counts = {2};
  plate.segment_counts = {4, 4};
  plate.degrees.assign(8, 1);
  plate.trim_points = {{0, 0, 1},    {1, 0, 1},     {1, 1, 1},        {0, 1, 1},
                       {0.5f, 0, 1}, {0.75f, 0, 1}, {0.75f, 0.5f, 1}, {0.5f, 0.5f, 1}};
  for (const std::uint8_t keeps_outside : {std::uint8_t{0}, std::uint8_t{1}}) {
    plate.patches[0].keeps_outside = keeps_outside;
    const Scene meshes = with_meshes_for_surfaces(scene_of(plate));
    const Mesh& mesh = *meshes.meshes[0];
    double area = 0, hole = 0;
    for (const auto& t : mesh.triangles) {
      const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
      EXPECT_GT(cross(b - a, c - a).z, 0);
      area += 0.5 * cross(b - a, c - a).z;
      const Vec3f middle = (1.0f / 3) * (a + b + c);
      if (middle.x > 0.5f && middle.x < 0.75f && middle.y < 0.5f) hole += 1;
    }
    EXPECT_NEAR(area, keeps_outside == 0 ? 0.875 : 0.125, 1e-6);
    EXPECT_EQ(hole, keeps_outside == 0 ? 0 : 16);
  }
}

// A line and a parabola, v = 1/4 + 3/8 (1 - (4 u - 2)^2), behind a loop too small for any middle.
TEST(PatchNet, CellsFollowCurvesToTheEndOfTheirLoop) {
  PatchSurface plate;
  plate.materials = {0};
  add_plate(plate, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  plate.loop_counts = {2};
  plate.segment_counts = {2, 2};
  plate.degrees = {1, 2, 1, 2};
  plate.trim_points = {{0, 0, 1},         {0, 0.01f, 1},     {0.01f, 0, 1},
                       {0.25f, 0.25f, 1}, {0.75f, 0.25f, 1}, {0.5f, 1, 1}};
  plate.patches[0].keeps_outside = 1;
  const Scene meshes = with_meshes_for_surfaces(scene_of(plate));
  // Below it are one middle in the columns at its ends and three in those beside its top.
  EXPECT_EQ(meshes.triangle_count(), 2u * (64 - 8));
}

TEST(PatchNet, ARoomOfPatchesIsShownFromWithin) {
  const Scene closed = scene_of(room());
  ASSERT_TRUE(validate_scene(closed).is_ok());
  const SceneOverview overview(closed);
  EXPECT_TRUE(overview.is_inside());
  const Camera camera = overview.default_camera(4.0 / 3);
  EXPECT_TRUE(camera.eye.x > 0 && camera.eye.x < 8 && camera.eye.y > 0 && camera.eye.y < 3 &&
              camera.eye.z > 0 && camera.eye.z < 5);
  // The longest sight is along x.
  EXPECT_GT(std::abs(normalize(camera.target - camera.eye).x), 0.7f);
  // Nothing is left of the wall in front but a frame around a loop of four lines.
  PatchSurface open = room();
  open.loop_counts = {0, 0, 0, 0, 0, 1};
  open.segment_counts = {4};
  open.degrees.assign(4, 1);
  open.trim_points = {{0.01f, 0.01f, 1}, {0.99f, 0.01f, 1}, {0.99f, 0.99f, 1}, {0.01f, 0.99f, 1}};
  open.patches.back().keeps_outside = 1;
  const SceneOverview stage(scene_of(open));
  EXPECT_FALSE(stage.is_inside());
  EXPECT_GT(stage.default_camera(4.0 / 3).eye.z, 5);
}

TEST(PatchNet, ScenesOfNoPatchesAreEmpty) {
  PatchSurface nothing;
  nothing.materials = {0};
  const Scene scene = scene_of(nothing);
  EXPECT_TRUE(SupportMap(scene).is_empty());
  EXPECT_TRUE(validate_scene(with_meshes_for_surfaces(scene)).is_ok());
}

}  // namespace
}  // namespace tessera
