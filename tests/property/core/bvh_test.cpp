// Property: whatever the triangles, the wide hierarchy keeps the invariants of bvh.h and does not
// depend on the number of threads.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "slave/core/accel/bvh_builder.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

struct Triangles {
  TriangleStore store;
  std::vector<Bounds3f> boxes;

  explicit Triangles(Mesh mesh) {
    store = make_triangle_store(test::make_scene(std::move(mesh)), boxes);
  }
  template <int W>
  Result<Bvh<W>> build(int threads) const {
    return build_bvh<W>(boxes, store.vertices, {threads, nullptr});
  }
};

Mesh in_plane(Mesh mesh) {
  for (Vec3f& p : mesh.positions) p.y = 0.5f;
  return mesh;
}

// All centroids fall together: there is nothing to sort by.
Mesh stacked(std::uint32_t count) {
  Mesh mesh = test::make_random_triangles(1, 1, 7);
  mesh.triangles.resize(count, mesh.triangles[0]);
  return mesh;
}

// Each triangle a tenth of the one before, towards one point: splits take off one at a time.
Mesh shrinking(std::uint32_t count) {
  Mesh mesh = test::make_random_triangles(count, 1, 8);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.positions[i] = mesh.positions[i] * std::pow(0.1f, static_cast<float>(i / 3 % 40));
  }
  return mesh;
}

template <int W>
void expect_sound(const Triangles& triangles) {
  const auto bvh = triangles.build<W>(1);
  ASSERT_TRUE(bvh.is_ok()) << bvh.status().message();
  const Status status = bvh->validate(triangles.boxes);
  EXPECT_TRUE(status.is_ok()) << status.message();
}

TEST(Bvh, KeepsItsInvariantsForEveryKindOfMesh) {
  const std::pair<const char*, Mesh> meshes[] = {
      {"cube", test::make_cube()},
      {"torus", test::make_torus(120, 60)},
      {"terrain", test::make_terrain(80, 3)},
      {"soup", test::make_random_triangles(30000, 0.1f, 1)},
      {"large triangles", test::make_random_triangles(1500, 2.0f, 2)},
      {"one plane", in_plane(test::make_random_triangles(2000, 0.1f, 3))},
      {"one point", stacked(5000)},
      {"shrinking", shrinking(3000)},
      {"nothing", stacked(0)},
  };
  for (const auto& [name, mesh] : meshes) {
    SCOPED_TRACE(name);
    const Triangles triangles(mesh);
    expect_sound<8>(triangles);
    expect_sound<16>(triangles);
  }
}

TEST(Bvh, LeavesDegenerateTrianglesOut) {
  Mesh mesh = test::make_random_triangles(500, 0.2f, 5);
  for (std::size_t i = 0; i < 500; i += 5) mesh.triangles[i][1] = mesh.triangles[i][0];
  expect_sound<8>(Triangles(mesh));
}

template <int W>
void expect_same_for_any_threads(const Triangles& triangles) {
  const auto one = triangles.build<W>(1);
  ASSERT_TRUE(one.is_ok());
  for (const int threads : {2, 3, 7}) {
    const auto many = triangles.build<W>(threads);
    ASSERT_TRUE(many.is_ok());
    ASSERT_EQ(one->nodes.size(), many->nodes.size());
    ASSERT_EQ(one->blocks.size(), many->blocks.size());
    EXPECT_EQ(0, std::memcmp(one->nodes.data(), many->nodes.data(),
                             one->nodes.size() * sizeof(BvhNode<W>)));
    EXPECT_EQ(0, std::memcmp(one->blocks.data(), many->blocks.data(),
                             one->blocks.size() * sizeof(TriangleBlock<W>)));
  }
}

TEST(Bvh, DoesNotDependOnTheNumberOfThreads) {
  const Triangles triangles(test::make_random_triangles(60000, 0.05f, 4));
  expect_same_for_any_threads<8>(triangles);
  expect_same_for_any_threads<16>(triangles);
}

TEST(Bvh, ACancelledBuildSaysSo) {
  const Triangles triangles(test::make_random_triangles(20000, 0.05f, 4));
  const std::atomic<bool> is_cancelled{true};
  const auto bvh = build_bvh<8>(triangles.boxes, triangles.store.vertices, {2, &is_cancelled});
  EXPECT_EQ(bvh.status().code(), StatusCode::kCancelled);
}

}  // namespace
}  // namespace tessera::core
