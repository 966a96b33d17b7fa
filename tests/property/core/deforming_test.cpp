// SPDX-License-Identifier: Apache-2.0
// Property: a version of a scene in which corners have moved has the bits of the same scene built
// on its own, whether its structure was fitted or built again; it is built again when rays in it
// have become too dear, and the number of threads does not matter.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "slave/core/accel/bvh_fit.h"
#include "slave/core/primitive/triangle/triangle_writer.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/flattened_twin.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

using Prepared = std::shared_ptr<const PreparedScene>;

Prepared prepare(const Scene& scene, const PreparedScene* other, int threads = 1) {
  BuildOptions options;
  options.other = other;
  options.threads = threads;
  auto built = PreparedScene::build(scene, options);
  EXPECT_TRUE(built.is_ok());
  return *built;
}

// A terrain that swings, and a ball above it that breathes and moves.
Scene swinging(float time) {
  Mesh ground = test::make_terrain(40, 3);
  for (Vec3f& p : ground.positions) p.y += 0.2f * std::sin(7 * p.x + 5 * p.z + time);
  Mesh ball = test::make_icosphere(3);
  for (Vec3f& p : ball.positions) p = p * (0.4f + 0.1f * std::sin(time));
  Scene scene = test::make_scene(ground);
  scene.meshes.push_back(std::make_shared<const Mesh>(ball));
  scene.instances.push_back({1, {}});
  scene.instances[1].object_to_world.m[1][3] = 1 + 0.3f * time;
  return scene;
}

void expect_bits_of_built(const Scene& scene, const PreparedScene& version) {
  std::mt19937 random(test::seed(1));
  const Prepared alone = prepare(scene, nullptr);
  EXPECT_EQ(alone->impl().index.bounds().lower, version.impl().index.bounds().lower);
  EXPECT_EQ(alone->impl().index.bounds().upper, version.impl().index.bounds().upper);
  EXPECT_EQ(alone->degenerate_count(), version.degenerate_count());
  EXPECT_EQ(alone->impl().geometry->left_out, version.impl().geometry->left_out);
  const std::size_t hits = test::compare_with_flattened(
      *alone, version, test::rays_around(alone->impl().triangles, 2000, random));
  EXPECT_GT(hits, 300u);
}

TEST(Deforming, FittedVersionsHaveTheBitsOfBuiltOnes) {
  Prepared version = prepare(swinging(0), nullptr);
  for (int frame = 1; frame <= 8; ++frame) {
    const Scene scene = swinging(0.1f * static_cast<float>(frame));
    version = prepare(scene, version.get(), 1 + frame % 3);
    EXPECT_EQ(version->fitted_primitives(), scene.triangle_count());
    EXPECT_EQ(version->built_primitives(), 0u);
    expect_bits_of_built(scene, *version);
  }
}

// Triangles that lie beside each other go anywhere.
TEST(Deforming, IsBuiltAgainWhenRaysHaveBecomeTooDear) {
  const Scene before = test::make_scene(test::make_terrain(40, 3));
  Mesh mixed = *before.meshes[0];
  std::mt19937 random(3);
  for (Vec3f& p : mixed.positions) {
    p = {std::uniform_real_distribution<float>(-1, 1)(random),
         std::uniform_real_distribution<float>(-1, 1)(random),
         std::uniform_real_distribution<float>(-1, 1)(random)};
  }
  const Scene after = test::make_scene(mixed);
  const Prepared first = prepare(before, nullptr);
  const Prepared version = prepare(after, first.get());
  EXPECT_EQ(version->fitted_primitives(), 0u);
  EXPECT_EQ(version->built_primitives(), after.triangle_count());
  EXPECT_EQ(version->impl().geometry->built_cost, 0);
  expect_bits_of_built(after, *version);
}

// Small steps add up: the cost is compared with that of the structure as it was built.
TEST(Deforming, ManySmallStepsEndInABuild) {
  Scene scene = test::make_scene(test::make_terrain(40, 3));
  Prepared version = prepare(scene, nullptr);
  int fits = 0, builds = 0;
  std::mt19937 random(4);
  for (int frame = 0; frame < 60 && builds == 0; ++frame) {
    Mesh mesh = *scene.meshes[0];
    for (Vec3f& p : mesh.positions) {
      p.x += std::uniform_real_distribution<float>(-0.004f, 0.004f)(random);
      p.z += std::uniform_real_distribution<float>(-0.004f, 0.004f)(random);
    }
    scene = test::make_scene(mesh);
    version = prepare(scene, version.get());
    (version->fitted_primitives() > 0 ? fits : builds) += 1;
  }
  EXPECT_GE(fits, 2);
  EXPECT_EQ(builds, 1);
  expect_bits_of_built(scene, *version);
}

// A triangle without area stands in no leaf, so one that gets some cannot be fitted.
TEST(Deforming, IsBuiltAgainWhenATriangleGetsOrLosesItsArea) {
  Mesh mesh = test::make_terrain(20, 3);
  const Prepared whole = prepare(test::make_scene(mesh), nullptr);
  const Vec3f kept = mesh.positions[mesh.triangles[7][0]];
  mesh.positions[mesh.triangles[7][0]] = mesh.positions[mesh.triangles[7][1]];
  const Scene flat = test::make_scene(mesh);
  const Prepared less = prepare(flat, whole.get());
  EXPECT_GT(less->degenerate_count(), 0u);
  EXPECT_EQ(less->fitted_primitives(), 0u);
  expect_bits_of_built(flat, *less);
  mesh.positions[mesh.triangles[7][0]] = kept;
  const Scene again = test::make_scene(mesh);
  const Prepared more = prepare(again, less.get());
  EXPECT_EQ(more->fitted_primitives(), 0u);
  EXPECT_EQ(more->degenerate_count(), 0u);
  expect_bits_of_built(again, *more);
}

template <int W>
void expect_exact_boxes() {
  std::vector<Bounds3f> boxes;
  const TriangleStore before = make_triangle_store(swinging(0), boxes);
  auto built = index_by_bvh<W>(boxes, before.vertices, {1, nullptr});
  ASSERT_TRUE(built.is_ok());
  const TriangleStore after = make_triangle_store(swinging(2), boxes);
  auto one = fit_index<W>(*built, after.vertices, {1, nullptr});
  ASSERT_TRUE(one.is_ok());
  TriangleWriter<W> leaves(after.vertices);
  for (const TriangleBlock<W>& block : one->triangles) {
    std::vector<std::uint32_t> primitives;
    for (const std::uint32_t p : block.primitive) {
      if (p < boxes.size()) primitives.push_back(p);
    }
    leaves.append(primitives);
  }
  const Status status = one->structure.validate({boxes, leaves});
  EXPECT_TRUE(status.is_ok()) << status.message();
  const TriangleBlocks<W> written = leaves.take();
  ASSERT_EQ(written.size(), one->triangles.size());
  EXPECT_EQ(0, std::memcmp(written.data(), one->triangles.data(),
                           written.size() * sizeof(TriangleBlock<W>)));
  for (const int threads : {2, 5}) {
    auto many = fit_index<W>(*built, after.vertices, {threads, nullptr});
    ASSERT_TRUE(many.is_ok());
    EXPECT_EQ(0, std::memcmp(many->structure.nodes.data(), one->structure.nodes.data(),
                             one->structure.nodes.size() * sizeof(BvhNode<W>)));
    EXPECT_EQ(sah_cost(many->structure), sah_cost(one->structure));
  }
}

TEST(Deforming, BlocksAreThoseOfABuildAndBoxesHoldThem) {
  expect_exact_boxes<8>();
  expect_exact_boxes<16>();
}

TEST(Deforming, IsCancelled) {
  std::atomic<bool> is_cancelled = true;
  std::vector<Bounds3f> boxes;
  const TriangleStore store = make_triangle_store(swinging(0), boxes);
  auto built = index_by_bvh<8>(boxes, store.vertices, {1, nullptr});
  ASSERT_TRUE(built.is_ok());
  EXPECT_EQ(fit_index<8>(*built, store.vertices, {1, &is_cancelled}).status().code(),
            StatusCode::kCancelled);
}

}  // namespace
}  // namespace tessera::core
