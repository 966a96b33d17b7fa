// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <map>

#include "common/scene/scene_codec.h"
#include "common/scene/validate.h"
#include "master/loader/load_scene.h"

namespace tessera::master {
namespace {

LoadedScene make(const std::string& name) {
  auto loaded = make_builtin(name);
  EXPECT_TRUE(loaded.is_ok()) << loaded.status().message();
  return loaded.is_ok() ? std::move(*loaded) : LoadedScene{};
}

TEST(Builtin, EveryOneIsValidHasACameraAndTheSameBitsEachTime) {
  ASSERT_GE(builtin_names().size(), 4u);
  for (const std::string& name : builtin_names()) {
    const LoadedScene loaded = make(name);
    const Status status = validate_scene(loaded.scene);
    EXPECT_TRUE(status.is_ok()) << name << ": " << status.message();
    EXPECT_TRUE(loaded.scene.camera.has_value()) << name;
    SceneEncoder first, second;
    EXPECT_EQ(first.encode(loaded.scene).digest(), second.encode(make(name).scene).digest())
        << name;
  }
}

TEST(Builtin, UnknownNamesAreRefusedWithTheKnownOnes) {
  auto loaded = make_builtin("castle");
  ASSERT_FALSE(loaded.is_ok());
  EXPECT_NE(loaded.status().message().find("cornell"), std::string::npos);
}

TEST(Builtin, TheRoomIsLargeAndFullOfThinParts) {
  const Scene scene = make("room").scene;
  EXPECT_GT(scene.triangle_count(), 200'000u);
  EXPECT_LT(scene.triangle_count(), 1'000'000u);
}

TEST(Builtin, TheTeapotIsItsPatches) {
  const Scene patches = make("teapot").scene, triangles = make("teapot-mesh").scene;
  EXPECT_EQ(patches.patch_count(), 32u);
  EXPECT_EQ(patches.triangle_count(), 6u) << "table, wall and lamp";
  EXPECT_EQ(triangles.patch_count(), 0u);
  EXPECT_EQ(triangles.triangle_count(), 6u + 32 * 28 * 28 * 2);
  EXPECT_EQ(patches.materials, triangles.materials);
  EXPECT_EQ(patches.lights, triangles.lights);
  // Corners of patches are points of the mesh, which lie on a grid of 2^-20.
  const Mesh& mesh = *triangles.meshes[0];
  constexpr std::size_t kStride = 29;
  for (PatchCursor at(*patches.surfaces[0]); at.is_any(); at.advance()) {
    const std::size_t first = at.patch() * kStride * kStride;
    const std::pair<std::size_t, std::size_t> corners[] = {
        {0, 0}, {3, kStride - 1}, {12, (kStride - 1) * kStride}, {15, kStride * kStride - 1}};
    for (const auto& [point, vertex] : corners)
      EXPECT_LT(length(at.point(point) - mesh.positions[first + vertex]), 1e-6f) << at.patch();
  }
}

// Every edge of the teapot's inside joins two triangles, up to its open rims: the patches share
// their border points.
TEST(Builtin, TheTeapotHasNoCracksBetweenItsPatches) {
  const Scene scene = make("teapot-mesh").scene;
  std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> uses;
  const auto key = [](Vec3f p) { return std::array<float, 3>{p.x, p.y, p.z}; };
  std::uint64_t edges = 0;
  for (const auto& mesh : scene.meshes) {
    for (const auto& t : mesh->triangles) {
      for (int k = 0; k < 3; ++k) {
        auto a = key(mesh->positions[t[static_cast<std::size_t>(k)]]);
        auto b = key(mesh->positions[t[static_cast<std::size_t>((k + 1) % 3)]]);
        if (a == b) continue;
        if (b < a) std::swap(a, b);
        ++uses[{a, b}];
        ++edges;
      }
    }
  }
  std::uint64_t open = 0;
  for (const auto& [edge, count] : uses) open += count == 1 ? 1 : 0;
  EXPECT_GT(edges, 100'000u);
  EXPECT_LT(open, edges / 50) << "only rims, the floor and the lamp are open";
}

TEST(Builtin, WavesMoveAndShareWhatStands) {
  const LoadedScene waves = make("waves");
  ASSERT_TRUE(waves.is_animated);
  const Scene now = waves.at_time(0), later = waves.at_time(0.5), again = waves.at_time(0.5);
  EXPECT_NE(*now.meshes[0], *later.meshes[0]);
  EXPECT_EQ(*later.meshes[0], *again.meshes[0]);
  EXPECT_TRUE(validate_scene(later).is_ok());
  for (std::size_t i = 1; i < now.meshes.size(); ++i) EXPECT_EQ(now.meshes[i], later.meshes[i]);
}

TEST(Builtin, ConesMoveTheirCornersAlone) {
  const LoadedScene patches = make("cones"), triangles = make("cones-mesh");
  EXPECT_EQ(patches.scene.patch_count(), 4u * 144);
  const Scene now = triangles.at_time(0), later = triangles.at_time(0.5);
  EXPECT_NE(now.meshes[0]->positions, later.meshes[0]->positions);
  EXPECT_EQ(now.meshes[0]->triangles, later.meshes[0]->triangles);
  EXPECT_NE(*patches.at_time(0).surfaces[0], *patches.at_time(0.5).surfaces[0]);
  EXPECT_TRUE(validate_scene(later).is_ok());
}

TEST(Builtin, TheTeapotsAreAsManyAsInTheThesis) {
  const Scene scene = make("teapots").scene;
  EXPECT_EQ(scene.surfaces.size(), 1u);
  EXPECT_EQ(scene.instances.size(), 32768u + 1);
}

TEST(Builtin, TheTeapotsApartStandWhereTheInstancesDo) {
  const Scene apart = make("teapots-apart").scene, scene = make("teapots").scene;
  EXPECT_EQ(apart.patch_count(), scene.patch_count());
  EXPECT_TRUE(validate_scene(apart).is_ok());
  const Bounds3f one = scene_bounds(apart), other = scene_bounds(scene);
  EXPECT_LT(length(one.upper - other.upper) + length(one.lower - other.lower), 1e-2f);
}

TEST(Builtin, TheTeapotsOfTrianglesStandWhereThoseOfPatchesDo) {
  const Scene triangles = make("teapots-mesh").scene, patches = make("teapots").scene;
  EXPECT_TRUE(triangles.surfaces.empty());
  ASSERT_EQ(triangles.instances.size(), patches.instances.size());
  EXPECT_TRUE(validate_scene(triangles).is_ok());
  for (std::size_t i = 0; i < patches.instances.size(); ++i)
    ASSERT_EQ(triangles.instances[i].object_to_world, patches.instances[i].object_to_world);
  const Mesh& teapot = *triangles.meshes[triangles.instances[0].mesh];
  EXPECT_EQ(teapot.triangles.size(), 4096u);
  const auto box_of = [](const Mesh& mesh) {
    Bounds3f box;
    for (const Vec3f& at : mesh.positions) box.grow(at);
    return box;
  };
  const Bounds3f box = box_of(teapot), fine = box_of(*make("teapot-mesh").scene.meshes[0]);
  EXPECT_LT(length(box.upper - fine.upper) + length(box.lower - fine.lower), 0.05f);
}

// A slave has nothing to fetch from frame to frame but the light.
TEST(Builtin, TheEveningMovesItsLightAlone) {
  const LoadedScene evening = make("evening");
  ASSERT_TRUE(evening.is_animated);
  const Scene now = evening.at_time(0), later = evening.at_time(2);
  EXPECT_NE(now.lights, later.lights);
  EXPECT_EQ(now.meshes, later.meshes);
  EXPECT_EQ(now.instances, later.instances);
  EXPECT_EQ(now.materials, later.materials);
  EXPECT_TRUE(validate_scene(later).is_ok());
}

}  // namespace
}  // namespace tessera::master
