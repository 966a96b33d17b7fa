// SPDX-License-Identifier: Apache-2.0
// Tangents that files do not have are those computed from the definition, corner by corner and in
// double precision, with no groups and no neighbours. That suffices since on these meshes all
// triangles around a vertex that turn the same way are joined.
#include "master/import/gltf/tangent_space.h"
#include "tests/support/seed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tessera::import {
namespace {

struct Vector {
  double x = 0, y = 0, z = 0;
  Vector operator-(const Vector& o) const { return {x - o.x, y - o.y, z - o.z}; }
  Vector operator+(const Vector& o) const { return {x + o.x, y + o.y, z + o.z}; }
  Vector operator*(double s) const { return {x * s, y * s, z * s}; }
};
double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector unit(const Vector& a) { return a * (1 / std::sqrt(dot(a, a))); }
Vector wide(Vec3f v) { return {double{v.x}, double{v.y}, double{v.z}}; }

double area_of(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const auto uv = [&](std::size_t k) { return mesh.uvs[t[k]]; };
  return double{uv(1).x - uv(0).x} * double{uv(2).y - uv(0).y} -
         double{uv(1).y - uv(0).y} * double{uv(2).x - uv(0).x};
}

// Tangent of `vertex`: the mean, by angles, over every triangle with an equal vertex and
// coordinates that turn the same way.
Vector by_definition(const Mesh& mesh, std::uint32_t vertex, bool turns_left) {
  const Vector normal = unit(wide(mesh.normals[vertex]));
  const auto on_plane = [&](const Vector& v) { return unit(v - normal * dot(normal, v)); };
  Vector sum;
  for (const auto& t : mesh.triangles) {
    const double area = area_of(mesh, t);
    if ((area > 0) != turns_left) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const bool is_equal = mesh.positions[t[k]] == mesh.positions[vertex] &&
                            mesh.normals[t[k]] == mesh.normals[vertex] &&
                            mesh.uvs[t[k]] == mesh.uvs[vertex];
      if (!is_equal) continue;
      const auto at = [&](std::size_t i) { return wide(mesh.positions[t[i % 3]]); };
      const auto uv = [&](std::size_t i) { return mesh.uvs[t[i % 3]]; };
      const Vector along = ((at(1) - at(0)) * double{uv(2).y - uv(0).y} -
                            (at(2) - at(0)) * double{uv(1).y - uv(0).y}) *
                           (1 / area);
      const double angle = std::acos(dot(on_plane(at(k + 1) - at(k)), on_plane(at(k + 2) - at(k))));
      sum = sum + on_plane(unit(along)) * angle;
    }
  }
  return unit(sum);
}

// A bumpy sheet; the right half has the picture of the left one, mirrored.
Mesh sheet(int side, bool is_mirrored, unsigned seed) {
  std::mt19937 random(test::seed(seed));
  const auto draw = [&] { return std::uniform_real_distribution<float>(-0.2f, 0.2f)(random); };
  Mesh mesh;
  for (int j = 0; j <= side; ++j) {
    for (int i = 0; i <= side; ++i) {
      const float x = static_cast<float>(i), y = static_cast<float>(j);
      mesh.positions.push_back({x + draw(), y + draw(), 2 * draw()});
      mesh.normals.push_back(normalize(Vec3f{draw(), draw(), 1}));
      const float u = is_mirrored && 2 * i > side ? static_cast<float>(side) - x : x;
      mesh.uvs.push_back({u, y + 0.3f * x});
    }
  }
  const auto n = static_cast<std::uint32_t>(side + 1);
  for (std::uint32_t j = 0; j + 1 < n; ++j) {
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i;
      mesh.triangles.push_back({a, a + 1, a + n + 1});
      mesh.triangles.push_back({a, a + n + 1, a + n});
    }
  }
  mesh.materials = {0};
  return mesh;
}

void expect_as_defined(const Mesh& before, const Mesh& after) {
  ASSERT_EQ(after.triangles.size(), before.triangles.size());
  ASSERT_EQ(after.tangents.size(), after.positions.size());
  for (std::size_t t = 0; t < before.triangles.size(); ++t) {
    const bool turns_left = area_of(before, before.triangles[t]) > 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = after.triangles[t][k];
      ASSERT_EQ(after.positions[vertex], before.positions[before.triangles[t][k]]);
      const Vec4f found = after.tangents[vertex];
      const Vector expected = by_definition(before, before.triangles[t][k], turns_left);
      EXPECT_EQ(found.w, turns_left ? 1.0f : -1.0f);
      // Up to 8 unit vectors of some 10 roundings each are added: 80 * 2^-24, and as much again for
      // the angles.
      EXPECT_NEAR(double{found.x}, expected.x, 1e-5);
      EXPECT_NEAR(double{found.y}, expected.y, 1e-5);
      EXPECT_NEAR(double{found.z}, expected.z, 1e-5);
    }
  }
}

TEST(TangentSpace, IsThatOfItsDefinition) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Mesh before = sheet(6, false, seed);
    Mesh after = before;
    make_tangents(after, after.uvs);
    expect_as_defined(before, after);
    EXPECT_EQ(after.positions.size(), before.positions.size()) << "nothing to be copied";
  }
}

TEST(TangentSpace, VerticesOfAMirrorsSeamHaveOneForEachSide) {
  const Mesh before = sheet(6, true, 7);
  Mesh after = before;
  make_tangents(after, after.uvs);
  expect_as_defined(before, after);
  EXPECT_EQ(after.positions.size(), before.positions.size() + 7) << "one column is copied";
  EXPECT_EQ(after.normals.size(), after.positions.size());
  EXPECT_EQ(after.uvs.size(), after.positions.size());
}

TEST(TangentSpace, EqualVerticesAreOneWhateverTheirIndices) {
  const Mesh joined = sheet(4, false, 3);
  Mesh apart;
  for (const auto& t : joined.triangles) {
    const auto first = static_cast<std::uint32_t>(apart.positions.size());
    for (const std::uint32_t vertex : t) {
      apart.positions.push_back(joined.positions[vertex]);
      apart.normals.push_back(joined.normals[vertex]);
      apart.uvs.push_back(joined.uvs[vertex]);
    }
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  Mesh after = joined;
  make_tangents(after, after.uvs);
  make_tangents(apart, apart.uvs);
  for (std::size_t t = 0; t < joined.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(apart.tangents[apart.triangles[t][k]], after.tangents[after.triangles[t][k]]);
  }
}

TEST(TangentSpace, TrianglesWithoutAnAreaGetAUnitTangentAcrossTheNormal) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}};
  mesh.normals = {{0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {0, 0, 0}};
  mesh.uvs = {{0.5f, 0.5f}, {0.5f, 0.5f}, {0.5f, 0.5f}, {0.5f, 0.5f}};
  mesh.triangles = {{0, 1, 2}, {0, 0, 1}, {0, 3, 1}};
  make_tangents(mesh, mesh.uvs);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3f along{mesh.tangents[v].x, mesh.tangents[v].y, mesh.tangents[v].z};
    EXPECT_NEAR(length(along), 1, 1e-6f);
    EXPECT_NEAR(tessera::dot(along, mesh.normals[v]), 0, 1e-6f);
  }
}

}  // namespace
}  // namespace tessera::import
