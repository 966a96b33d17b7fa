// SPDX-License-Identifier: Apache-2.0
// Property: whatever the triangles, the wide hierarchy keeps the invariants of bvh.h and does not
// depend on the number of threads.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "slave/core/accel/bvh_builder.h"
#include "slave/core/accel/bvh_fast_builder.h"
#include "slave/core/accel/bvh_fit.h"
#include "slave/core/accel/tree_top.h"
#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_clipper.h"
#include "slave/core/primitive/triangle/triangle_store.h"
#include "slave/core/primitive/triangle/triangle_writer.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

template <int W>
struct Built {
  Bvh<W> bvh;
  TriangleWriter<W> leaves;
};

struct Triangles {
  TriangleStore store;
  std::vector<Bounds3f> boxes;

  explicit Triangles(Mesh mesh) {
    store = make_triangle_store(test::make_scene(std::move(mesh)), boxes);
  }
  template <int W>
  Result<Built<W>> build(const BvhBuildConfig& config) const {
    TriangleWriter<W> leaves(store.vertices);
    auto bvh = build_bvh<W>({boxes, leaves}, {1, nullptr}, config);
    if (!bvh.is_ok()) return bvh.status();
    return Built<W>{std::move(*bvh), std::move(leaves)};
  }
};

Mesh in_plane(Mesh mesh) {
  for (Vec3f& p : mesh.positions) p.y = 0.5f;
  return mesh;
}

// Triangles whose centroids fall together, so that there is nothing to sort by.
Mesh stacked(std::uint32_t count) {
  Mesh mesh = test::make_random_triangles(1, 1, 7);
  mesh.triangles.resize(count, mesh.triangles[0]);
  return mesh;
}

// Triangles that shrink towards one point, each a tenth of the one before, so that splits take off
// one at a time.
Mesh shrinking(std::uint32_t count) {
  Mesh mesh = test::make_random_triangles(count, 1, 8);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.positions[i] = mesh.positions[i] * std::pow(0.1f, static_cast<float>(i / 3 % 40));
  }
  return mesh;
}

// Cuts wherever there is room for it.
BvhBuildConfig many_cuts(const PrimitiveClipper& clipper) {
  BvhBuildConfig config = spatial_build(clipper);
  config.cuts_max = 0.5f;
  config.overlap_min = 0;
  config.overlap_share = 0;
  config.cut_weight = 0.5f;
  config.cuts_have_to_pay = false;
  return config;
}

template <int W>
void expect_sound_when_fast(const Triangles& triangles) {
  TriangleWriter<W> leaves(triangles.store.vertices);
  auto fast = build_bvh_fast<W>({triangles.boxes, leaves}, {1, nullptr});
  ASSERT_TRUE(fast.is_ok()) << fast.status().message();
  const Status status = fast->validate({triangles.boxes, leaves});
  EXPECT_TRUE(status.is_ok()) << "fast: " << status.message();
}

template <int W>
void expect_sound(const Triangles& triangles) {
  expect_sound_when_fast<W>(triangles);
  auto built = triangles.build<W>({});
  ASSERT_TRUE(built.is_ok()) << built.status().message();
  Status status = built->bvh.validate({triangles.boxes, built->leaves});
  EXPECT_TRUE(status.is_ok()) << status.message();
  const TriangleClipper clipper(triangles.store.vertices);
  auto cut = triangles.build<W>(many_cuts(clipper));
  ASSERT_TRUE(cut.is_ok()) << cut.status().message();
  status = cut->bvh.validate({triangles.boxes, cut->leaves}, &clipper);
  EXPECT_TRUE(status.is_ok()) << "cut: " << status.message();
}

// Leaves of the hierarchy list so many primitives.
template <int W>
std::size_t listed(Built<W>& built) {
  std::size_t count = 0;
  for (std::uint32_t b = 0; b < built.leaves.block_count(); ++b)
    count += built.leaves.primitives_of(b).size();
  return count;
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

TEST(Bvh, CutsTrianglesWithinItsBudget) {
  constexpr std::uint32_t kCount = 5000;
  const Triangles triangles(test::make_random_triangles(kCount, 0.2f, 2));
  const TriangleClipper clipper(triangles.store.vertices);
  for (const float cuts_max : {0.5f, 0.2f}) {
    BvhBuildConfig config = many_cuts(clipper);
    config.cuts_max = cuts_max;
    auto cut = triangles.build<8>(config);
    ASSERT_TRUE(cut.is_ok()) << cut.status().message();
    EXPECT_GT(listed(*cut), kCount + kCount / 20) << "hardly a triangle is cut";
    EXPECT_LE(listed(*cut), static_cast<std::size_t>((1 + cuts_max) * kCount));
  }
}

void add(const Mesh& part, Vec3f at, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec3f& p : part.positions) mesh.positions.push_back(p + at);
  for (const auto& t : part.triangles)
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

// Small triangles among some that are as large as all of them. Whatever is parted by centroids has
// halves as wide as the scene.
Mesh small_and_large() {
  Mesh mesh = test::make_random_triangles(30000, 0.02f, 9);
  add(test::make_random_triangles(300, 2.0f, 10), {0, 0, 0}, mesh);
  return mesh;
}

// Rings over one floor, which a cut in space parts with what stands on it, while splits by
// centroids soon have it to themselves.
Mesh rings_on_a_floor() {
  Mesh mesh;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vec3f at{2 * static_cast<float>(i) + 1, 0, 2 * static_cast<float>(j) + 1};
      add(test::make_torus(180, 30 * (1 + (i + j) % 3)), at, mesh);
    }
  }
  Mesh floor;
  floor.positions = {{0, -1.5f, 0}, {6, -1.5f, 0}, {6, -1.5f, 6}, {0, -1.5f, 6}};
  floor.triangles = {{0, 1, 2}, {0, 2, 3}};
  add(floor, {0, 0, 0}, mesh);
  return mesh;
}

void expect_cuts_where_they_pay(const Triangles& triangles, bool do_pay) {
  const TriangleClipper clipper(triangles.store.vertices);
  const BvhBuildConfig usual = usual_build(clipper);
  TriangleWriter<8> leaves(triangles.store.vertices);
  const PrimitiveSet set{triangles.boxes, leaves};
  const BuildControl alone{1, nullptr};
  const TreeTop cut(set, 8, alone, usual), uncut(set, 8, alone, {});
  EXPECT_TRUE(cut.has_cuts_in_space());
  EXPECT_EQ(cut.cost() < uncut.cost(), do_pay) << cut.cost() << ", uncut " << uncut.cost();
  EXPECT_EQ(do_cuts_pay(set, 8, alone, usual), do_pay);
  auto built = triangles.build<8>(usual);
  ASSERT_TRUE(built.is_ok()) << built.status().message();
  const Status status =
      built->bvh.validate({triangles.boxes, built->leaves}, do_pay ? &clipper : nullptr);
  EXPECT_TRUE(status.is_ok()) << status.message();
  const std::size_t count = triangles.boxes.size();
  EXPECT_EQ(listed(*built) > count, do_pay);
  EXPECT_LE(static_cast<double>(listed(*built)),
            (1 + double{usual.cuts_max}) * static_cast<double>(count));
}

TEST(Bvh, CutsNearTheRootHaveToPay) {
  expect_cuts_where_they_pay(Triangles(small_and_large()), true);
  expect_cuts_where_they_pay(Triangles(rings_on_a_floor()), false);
}

// Also where cuts do not pay, for then none is made.
TEST(Bvh, QualityCostsRaysLess) {
  for (const Mesh& mesh : {small_and_large(), rings_on_a_floor(), test::make_torus(300, 150),
                           test::make_random_triangles(30000, 0.05f, 1)}) {
    const Triangles triangles(mesh);
    const TriangleClipper clipper(triangles.store.vertices);
    const auto usual = triangles.build<16>(usual_build(clipper));
    const auto quality = triangles.build<16>(spatial_build(clipper));
    ASSERT_TRUE(usual.is_ok() && quality.is_ok());
    EXPECT_LT(sah_cost(quality->bvh), sah_cost(usual->bvh));
  }
}

TEST(Bvh, LeavesDegenerateTrianglesOut) {
  Mesh mesh = test::make_random_triangles(500, 0.2f, 5);
  for (std::size_t i = 0; i < 500; i += 5) mesh.triangles[i][1] = mesh.triangles[i][0];
  expect_sound<8>(Triangles(mesh));
}

template <class Array>
void expect_same_bytes(const Array& a, const Array& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(0, std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])));
}

template <int W>
void expect_same_for_any_threads(const Triangles& triangles, const BvhBuildConfig& config) {
  const auto index = [&](int threads) {
    return std::move(
        *index_by_bvh<W>(triangles.boxes, triangles.store.vertices, {threads, nullptr}, config));
  };
  const auto fast = [&](int threads) {
    return std::move(*index_fast<W>(triangles.boxes, triangles.store.vertices, {threads, nullptr}));
  };
  const IndexedBvh<W> one = index(1), one_fast = fast(1);
  for (const int threads : {2, 3, 7}) {
    const IndexedBvh<W> many = index(threads);
    expect_same_bytes(one.structure.nodes, many.structure.nodes);
    expect_same_bytes(one.triangles, many.triangles);
    const IndexedBvh<W> many_fast = fast(threads);
    expect_same_bytes(one_fast.structure.nodes, many_fast.structure.nodes);
    expect_same_bytes(one_fast.triangles, many_fast.triangles);
  }
}

TEST(Bvh, DoesNotDependOnTheNumberOfThreads) {
  const Triangles triangles(test::make_random_triangles(60000, 0.05f, 4));
  expect_sound<8>(triangles);  // its root is split in parts
  const TriangleClipper clipper(triangles.store.vertices);
  for (const BvhBuildConfig& config : {BvhBuildConfig{}, many_cuts(clipper)}) {
    expect_same_for_any_threads<8>(triangles, config);
    expect_same_for_any_threads<16>(triangles, config);
  }
  const Triangles with_large(small_and_large());
  const TriangleClipper large_clipper(with_large.store.vertices);
  expect_same_for_any_threads<16>(with_large, usual_build(large_clipper));
}

TEST(Bvh, ACancelledBuildSaysSo) {
  const Triangles triangles(test::make_random_triangles(20000, 0.05f, 4));
  const std::atomic<bool> is_cancelled{true};
  const auto bvh = index_by_bvh<8>(triangles.boxes, triangles.store.vertices, {2, &is_cancelled});
  EXPECT_EQ(bvh.status().code(), StatusCode::kCancelled);
}

}  // namespace
}  // namespace tessera::core
