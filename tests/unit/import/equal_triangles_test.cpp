// SPDX-License-Identifier: Apache-2.0
#include "master/import/equal_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

namespace tessera::import {
namespace {

// A strip of `count` triangles, no two of which are equal.
Mesh strip(std::uint32_t count) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < count + 2; ++i)
    mesh.positions.push_back({static_cast<float>(i), static_cast<float>(i % 2), 0});
  for (std::uint32_t i = 0; i < count; ++i) {
    mesh.triangles.push_back({i, i + 1, i + 2});
    mesh.materials.push_back(i);
  }
  return mesh;
}

Scene scene_of(Mesh mesh) {
  Scene scene;
  scene.meshes.push_back(std::make_shared<Mesh>(std::move(mesh)));
  return scene;
}

TEST(EqualTriangles, AMeshWithoutAnyStaysTheSameObject) {
  Scene scene = scene_of(strip(100'000));
  const auto before = scene.meshes[0];
  EXPECT_EQ(leave_out_equal(scene), 0u);
  EXPECT_EQ(scene.meshes[0], before);
}

TEST(EqualTriangles, CopiesUpToTheBoundStay) {
  Mesh mesh = strip(1000);
  for (std::uint32_t i = 1; i < kEqualTrianglesMax; ++i) {
    mesh.triangles.push_back(mesh.triangles[500]);
    mesh.materials.push_back(7);
  }
  Scene scene = scene_of(std::move(mesh));
  EXPECT_EQ(leave_out_equal(scene), 0u);
}

// Copies in every order of the corners, by corners of their own, and with zeros of both signs.
TEST(EqualTriangles, TheFirstStayAndWithThemTheirMaterials) {
  Mesh mesh = strip(1000);
  constexpr std::uint32_t kCopies = 50'000;
  for (std::uint32_t i = 0; i < kCopies; ++i) {
    std::array<std::uint32_t, 3> t = mesh.triangles[0];  // corners (0,0,0), (1,1,0), (2,0,0)
    std::rotate(t.begin(), t.begin() + i % 3, t.end());
    if (i % 2 == 1) std::swap(t[0], t[1]);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const std::uint32_t corner : t) {
      Vec3f v = mesh.positions[corner];
      if (i % 5 == 0) v.z = -0.0f;
      mesh.positions.push_back(v);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.materials.push_back(5000 + i);
  }
  Scene scene = scene_of(std::move(mesh));
  EXPECT_EQ(leave_out_equal(scene), kCopies + 1 - kEqualTrianglesMax);
  const Mesh& left = *scene.meshes[0];
  ASSERT_EQ(left.triangles.size(), 1000 + kEqualTrianglesMax - 1);
  ASSERT_EQ(left.materials.size(), left.triangles.size());
  for (std::uint32_t i = 0; i < 1000; ++i) ASSERT_EQ(left.materials[i], i);
  for (std::uint32_t i = 0; i < kEqualTrianglesMax - 1; ++i)
    ASSERT_EQ(left.materials[1000 + i], 5000 + i) << "in the file's order";
}

TEST(EqualTriangles, OneMaterialForAllStaysOne) {
  Mesh mesh = strip(2);
  mesh.triangles.resize(1000, mesh.triangles[0]);
  mesh.materials = {3};
  Scene scene = scene_of(std::move(mesh));
  EXPECT_EQ(leave_out_equal(scene), 999 - kEqualTrianglesMax);
  EXPECT_EQ(scene.meshes[0]->materials, (std::vector<std::uint32_t>{3}));
}

}  // namespace
}  // namespace tessera::import
