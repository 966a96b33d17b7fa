// Property: whatever the triangles, the tree keeps the invariants of kd_tree.h, stays within its
// memory bound and does not depend on the number of threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "slave/core/accel/kd_builder.h"
#include "slave/core/geometry/triangle_store.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

std::vector<Bounds3f> boxes_of(Mesh mesh) {
  std::vector<Bounds3f> boxes;
  make_triangle_store(test::make_scene(std::move(mesh)), boxes);
  return boxes;
}

// All vertices on a grid of step 1/4: many faces of boxes coincide, many boxes are flat.
Mesh on_coarse_grid(Mesh mesh) {
  for (Vec3f& p : mesh.positions) {
    p = {std::round(p.x * 4) / 4, std::round(p.y * 4) / 4, std::round(p.z * 4) / 4};
  }
  return mesh;
}

Mesh in_plane(Mesh mesh) {
  for (Vec3f& p : mesh.positions) p.y = 0.5f;
  return mesh;
}

void expect_sound(const std::vector<Bounds3f>& boxes, const char* what,
                  const KdBuildConfig& config = {}) {
  SCOPED_TRACE(what);
  const Result<KdTree> tree = build_kd_tree(boxes, {1, nullptr}, config);
  ASSERT_TRUE(tree.is_ok()) << tree.status().message();
  const Status status = tree->validate(boxes);
  EXPECT_TRUE(status.is_ok()) << status.message();
  EXPECT_LE(tree->primitive_refs().size(),
            std::uint64_t{config.refs_per_primitive_max} * boxes.size() + 64);
}

TEST(KdTree, KeepsItsInvariantsForEveryKindOfMesh) {
  expect_sound(boxes_of(test::make_cube()), "cube");
  expect_sound(boxes_of(test::make_icosphere(4)), "icosphere");
  expect_sound(boxes_of(test::make_torus(120, 60)), "torus");
  expect_sound(boxes_of(test::make_terrain(80, 3)), "terrain");
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    expect_sound(boxes_of(test::make_random_triangles(3000, 0.1f, seed)), "soup");
    expect_sound(boxes_of(test::make_random_triangles(1500, 2.0f, seed)), "large triangles");
    expect_sound(boxes_of(on_coarse_grid(test::make_random_triangles(2000, 0.5f, seed))), "grid");
    expect_sound(boxes_of(in_plane(test::make_random_triangles(2000, 0.1f, seed))), "one plane");
  }
}

TEST(KdTree, KeepsItsMemoryBoundWhenTestsLookDear) {
  KdBuildConfig config;
  config.cost_intersect = 20;  // splits as long as it is let
  config.refs_per_primitive_max = 3;
  expect_sound(boxes_of(test::make_random_triangles(2000, 1.0f, 9)), "soup", config);
}

TEST(KdTree, DoesNotDependOnTheNumberOfThreads) {
  const std::vector<Bounds3f> boxes = boxes_of(test::make_random_triangles(60000, 0.05f, 4));
  const Result<KdTree> one = build_kd_tree(boxes, {1, nullptr});
  ASSERT_TRUE(one.is_ok());
  EXPECT_TRUE(one->validate(boxes).is_ok());
  for (const int threads : {2, 3, 7}) {
    const Result<KdTree> many = build_kd_tree(boxes, {threads, nullptr});
    ASSERT_TRUE(many.is_ok());
    ASSERT_EQ(one->nodes().size(), many->nodes().size());
    EXPECT_EQ(0, std::memcmp(one->nodes().data(), many->nodes().data(), one->nodes().size_bytes()));
    ASSERT_EQ(one->primitive_refs().size(), many->primitive_refs().size());
    EXPECT_TRUE(std::equal(one->primitive_refs().begin(), one->primitive_refs().end(),
                           many->primitive_refs().begin()));
  }
}

TEST(KdTree, DegenerateTrianglesKeepTheirNumberAndStayOut) {
  Mesh mesh = test::make_random_triangles(500, 0.2f, 5);
  for (std::size_t i = 0; i < 500; i += 5) mesh.triangles[i][1] = mesh.triangles[i][0];  // a line
  for (std::size_t i = 1; i < 500; i += 5) mesh.triangles[i] = {0, 0, 0};                // a point
  const std::vector<Bounds3f> boxes = boxes_of(mesh);
  ASSERT_EQ(500u, boxes.size());
  EXPECT_TRUE(boxes[5].is_empty());
  EXPECT_TRUE(boxes[6].is_empty());
  EXPECT_FALSE(boxes[7].is_empty());
  expect_sound(boxes, "with degenerate triangles");
}

TEST(KdTree, ValidateFindsAPrimitiveThatIsMissingFromALeaf) {
  const std::vector<Bounds3f> boxes = boxes_of(test::make_icosphere(3));
  const Result<KdTree> tree = build_kd_tree(boxes, {1, nullptr});
  ASSERT_TRUE(tree.is_ok());
  std::vector<KdNode> nodes(tree->nodes().begin(), tree->nodes().end());
  for (KdNode& node : nodes) {
    if ((node.tag_and_index & 3u) == kKdLeafTag && node.count > 1) {
      --node.count;
      break;
    }
  }
  const KdTree damaged(tree->bounds(), nodes,
                       {tree->primitive_refs().begin(), tree->primitive_refs().end()});
  EXPECT_FALSE(damaged.validate(boxes).is_ok());
}

TEST(KdTree, CancelledBuildSaysSo) {
  const std::atomic<bool> is_cancelled{true};
  const Result<KdTree> tree =
      build_kd_tree(boxes_of(test::make_random_triangles(5000, 0.1f, 1)), {2, &is_cancelled});
  ASSERT_FALSE(tree.is_ok());
  EXPECT_EQ(StatusCode::kCancelled, tree.status().code());
}

TEST(KdTree, EmptySceneIsOneEmptyLeaf) {
  const Result<KdTree> tree = build_kd_tree({}, {1, nullptr});
  ASSERT_TRUE(tree.is_ok());
  EXPECT_EQ(1u, tree->nodes().size());
  EXPECT_TRUE(tree->validate({}).is_ok());
}

}  // namespace
}  // namespace tessera::core
