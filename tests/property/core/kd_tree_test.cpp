// SPDX-License-Identifier: Apache-2.0
// Property: whatever the triangles, the tree keeps the invariants of kd_tree.h, stays within its
// memory bound and does not depend on the number of threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include "slave/core/accel/kd_builder.h"
#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

std::vector<Bounds3f> boxes_of(Mesh mesh) {
  std::vector<Bounds3f> boxes;
  make_triangle_store(test::make_scene(std::move(mesh)), boxes);
  return boxes;
}

// Moves all vertices to a grid of step 1/4, so that many faces of boxes coincide and many boxes are
// flat.
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

struct Cut {
  std::vector<Bounds3f> boxes;
  TriangleStore store;
  KdTree tree;

  Cut(const Mesh& mesh, float cost_intersect) {
    store = make_triangle_store(test::make_scene(mesh), boxes);
    const TriangleClipper clipper(store.vertices);
    KdBuildConfig config = quality_build(clipper);
    config.cost_intersect = cost_intersect;
    tree = std::move(*build_kd_tree(boxes, {2, nullptr}, config));
  }
};

// Returns: how many leaves have the point in their voxels, faces included, when none of them lists
// the triangle; else 0.
std::size_t leaves_without(const KdTree& tree, Vec3f p, std::uint32_t triangle) {
  std::vector<std::uint32_t> open{0};
  std::size_t missing = 0;
  bool is_listed = false;
  while (!open.empty()) {
    const KdNode node = tree.nodes()[open.back()];
    open.pop_back();
    const std::uint32_t tag = node.tag_and_index & 3u, index = node.tag_and_index >> 2;
    if (tag == kKdLeafTag) {
      const auto refs = tree.primitive_refs().subspan(index, node.count);
      const bool is_here = std::binary_search(refs.begin(), refs.end(), triangle);
      is_listed |= is_here;
      missing += is_here ? 0 : 1;
      continue;
    }
    const float x = p[static_cast<int>(tag)];
    if (x <= node.split) open.push_back(index);
    if (x >= node.split) open.push_back(index + 1);
  }
  // Where the point is on a face between voxels, one of them is enough.
  return is_listed ? 0 : missing;
}

TEST(KdTree, AQualityTreeListsATriangleWhereverAPointOfItIs) {
  const Mesh meshes[] = {test::make_icosphere(4), test::make_terrain(60, 3),
                         test::make_random_triangles(1500, 2.0f, 3),
                         on_coarse_grid(test::make_random_triangles(2000, 0.5f, 4))};
  const std::uint32_t seed = 31;
  std::size_t points = 0;
  for (const Mesh& plain : meshes) {
    for (const float scale : {1.0f, 1e-20f, 1e15f}) {
      Mesh mesh = plain;
      test::place(mesh, scale, {0, 0, 0});
      const Cut cut(mesh, 2);  // fine
      const Status status = cut.tree.validate(cut.boxes, true);
      EXPECT_TRUE(status.is_ok()) << status.message();
      std::mt19937 random(test::seed(seed));
      std::uniform_real_distribution<float> unit(0, 1);
      std::size_t missing = 0;
      for (int i = 0; i < 40'000; ++i, ++points) {
        const auto t = static_cast<std::uint32_t>(random() % cut.boxes.size());
        if (cut.boxes[t].is_empty()) continue;
        // Corners and middles of edges are points of the triangle to the bit, or nearly.
        const Vec3f a = cut.store.vertex(t, static_cast<int>(random() % 3)),
                    b = cut.store.vertex(t, static_cast<int>(random() % 3));
        missing += leaves_without(cut.tree, a, t);
        if (a.x == b.x || a.y == b.y || a.z == b.z) continue;
        const Vec3f p = a + (b - a) * unit(random);
        // p is off the edge by roundings, so it is looked for only where no split is as near as
        // that.
        const Vec3f near = p + (b - a) * 1e-5f, far = p - (b - a) * 1e-5f;
        std::size_t none = leaves_without(cut.tree, p, t);
        none = std::min(none, leaves_without(cut.tree, near, t));
        missing += std::min(none, leaves_without(cut.tree, far, t));
      }
      EXPECT_EQ(missing, 0u) << "seed " << seed << ", scale " << scale;
    }
  }
  EXPECT_GT(points, 400'000u);
}

// Trees with planes at bin borders, above so many primitives, cost at most 2 % more than trees for
// which all faces of boxes are tried.
TEST(KdTree, AQualityTreeIsAsGoodAsTheExactSweep) {
  const Mesh meshes[] = {test::make_icosphere(5), test::make_terrain(120, 3),
                         test::make_torus(200, 80), test::make_random_triangles(20'000, 0.1f, 5),
                         test::make_random_triangles(5'000, 1.0f, 6)};
  for (const Mesh& mesh : meshes) {
    std::vector<Bounds3f> boxes;
    const TriangleStore store = make_triangle_store(test::make_scene(mesh), boxes);
    const TriangleClipper clipper(store.vertices);
    for (const float cost : {0.025f, 0.5f}) {
      KdBuildConfig quality = quality_build(clipper);
      quality.cost_intersect = cost;
      KdBuildConfig exact = quality, fast;
      exact.sweep_max = boxes.size();
      fast.cost_intersect = cost;
      const auto cost_of = [&](const KdBuildConfig& config) {
        return build_kd_tree(boxes, {2, nullptr}, config)->sah_cost(config.cost_traverse, cost);
      };
      const double exact_cost = cost_of(exact);
      RecordProperty("cost", std::to_string(cost_of(quality) / exact_cost));
      EXPECT_LE(cost_of(quality), 1.02 * exact_cost) << boxes.size() << " at " << cost;
      EXPECT_LE(cost_of(quality), 1.02 * cost_of(fast)) << boxes.size() << " at " << cost;
    }
  }
}

TEST(KdTree, KeepsItsMemoryBoundWhenTestsLookDear) {
  KdBuildConfig config;
  config.cost_intersect = 20;  // splits for as long as the bounds let it
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

template <typename Array>
void expect_same_bytes(const Array& a, const Array& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(0, std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])));
}

// Enough triangles for several runs of leaves, and for voxels that several threads split; every
// seventh has no box.
TEST(KdTree, ItsIndexDoesNotDependOnTheNumberOfThreads) {
  Mesh mesh = test::make_random_triangles(60000, 0.02f, 4);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 7)
    mesh.triangles[i][1] = mesh.triangles[i][0];
  std::vector<Bounds3f> boxes;
  const TriangleStore store = make_triangle_store(test::make_scene(std::move(mesh)), boxes);
  const TriangleClipper clipper(store.vertices);
  for (const KdBuildConfig& config : {KdBuildConfig{}, quality_build(clipper)}) {
    const Result<KdTree> tree = build_kd_tree(boxes, {2, nullptr}, config);
    ASSERT_TRUE(tree.is_ok());
    const Status sound = tree->validate(boxes, config.clipper != nullptr);
    EXPECT_TRUE(sound.is_ok()) << sound.message();
    const auto index = [&](int threads) {
      return std::move(*index_by_kd<16>(boxes, store.vertices, {threads, nullptr}, config));
    };
    const IndexedKd<16> one = index(1);
    for (const int threads : {2, 5}) {
      const IndexedKd<16> many = index(threads);
      expect_same_bytes(one.structure.nodes, many.structure.nodes);
      expect_same_bytes(one.structure.leaves, many.structure.leaves);
      expect_same_bytes(one.triangles, many.triangles);
    }
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
