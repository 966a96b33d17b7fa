// SPDX-License-Identifier: Apache-2.0
// Property: versions of a scene that follow one another, in which instances move and meshes change,
// have the bits of scenes that were flattened and built on their own, and build what has changed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "slave/core/accel/bvh_children.h"
#include "slave/core/primitive/instance/flat_part.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/flattened_twin.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

using Random = std::mt19937;
using Prepared = std::shared_ptr<const PreparedScene>;

float unit(Random& random) { return std::uniform_real_distribution<float>(-1, 1)(random); }

Transform place(Random& random) {
  Transform t;
  const float angle = 3 * unit(random), size = 0.3f + 0.2f * unit(random);
  t.m[0] = {size * std::cos(angle), -size * std::sin(angle), 0, 6 * unit(random)};
  t.m[1] = {size * std::sin(angle), size * std::cos(angle), 0, 6 * unit(random)};
  t.m[2] = {0, 0, size, unit(random)};
  return t;
}

// A terrain that stands once, and balls and heaps of triangles above it, by turns.
Scene make_field(std::size_t count, Random& random) {
  Scene scene = test::make_scene(test::make_terrain(30, 3));
  scene.meshes.push_back(std::make_shared<const Mesh>(test::make_icosphere(2)));
  scene.meshes.push_back(std::make_shared<const Mesh>(test::make_random_triangles(90, 0.5f, 5)));
  for (std::size_t i = 0; i < count; ++i)
    scene.instances.push_back({1 + static_cast<std::uint32_t>(i % 2), place(random)});
  return scene;
}

Prepared prepare(const Scene& scene, const PreparedScene* other,
                 Instancing instancing = Instancing::kAuto) {
  BuildOptions options;
  options.other = other;
  options.instancing = instancing;
  auto built = PreparedScene::build(scene, options);
  EXPECT_TRUE(built.is_ok());
  return *built;
}

// Returns: the number of rays that hit something in both.
std::size_t compare(const Scene& scene, const PreparedScene& version, std::size_t rays,
                    Random& random) {
  const Prepared flat = prepare(scene, nullptr, Instancing::kNever);
  const Bounds3f wanted = flat->impl().index.bounds(), found = version.impl().index.bounds();
  EXPECT_EQ(wanted.lower, found.lower);
  EXPECT_EQ(wanted.upper, found.upper);
  EXPECT_EQ(flat->degenerate_count(), version.degenerate_count());
  return test::compare_with_flattened(*flat, version,
                                      test::rays_around(flat->impl().triangles, rays, random));
}

// How often each instance stands in the hierarchy over the instances; boxes hold what is below.
template <int W>
std::vector<int> listed(const InstancedBvh<W>& index) {
  std::vector<int> times(index.instances.size(), 0);
  struct Open {
    std::uint32_t child;
    Bounds3f box;
  };
  const auto holds = [](const Bounds3f& outer, const Bounds3f& box) {
    Bounds3f both = outer;
    both.grow(box);
    return both.lower == outer.lower && both.upper == outer.upper;
  };
  std::vector<Open> open{{0, index.structure.bounds}};
  while (!open.empty()) {
    const Open at = open.back();
    open.pop_back();
    if ((at.child & kBvhLeaf) != 0) {
      const std::uint32_t first = first_block_of(at.child), count = block_count_of(at.child);
      for (std::uint32_t b = first; b < first + count; ++b) {
        const std::uint32_t instance = index.blocks[b] ^ kIsItem;
        ++times[instance];
        EXPECT_TRUE(holds(at.box, index.boxes[instance]));
      }
      continue;
    }
    const BvhNode<W>& node = index.structure.nodes[at.child];
    for (int i = 0; i < W; ++i) {
      if (node.child[i] == kBvhNoChild) continue;
      const Bounds3f box = child_box(node, i);
      EXPECT_TRUE(box.is_empty() || holds(at.box, box));
      open.push_back({node.child[i], box});
    }
  }
  return times;
}

// Returns: moves since the hierarchy over the instances was built as a whole.
std::uint64_t expect_sound(const PreparedScene& version) {
  std::uint64_t moves = 0;
  bool is_instanced = false;
  std::visit(
      [&](const auto& index) {
        if constexpr (requires { index.moves; }) {
          moves = index.moves;
          is_instanced = true;
          const std::vector<int> times = listed(index);
          EXPECT_EQ(times, std::vector<int>(times.size(), 1));
        }
      },
      version.impl().index.any);
  EXPECT_TRUE(is_instanced);
  return moves;
}

TEST(MovedInstances, HaveTheBitsOfTheFlattenedScene) {
  const unsigned seed = test::seed();
  TESSERA_TRACE_SEED(seed);
  Random random(seed);
  Scene scene = make_field(120, random);
  Prepared newest = prepare(scene, nullptr);
  std::uint64_t most_moves = 0;
  std::size_t hits = 0;
  for (int version = 0; version < 60; ++version) {
    const int count = version % 7 == 6 ? 5 : 1;
    for (int k = 0; k < count; ++k) {
      const std::size_t i = 1 + random() % (scene.instances.size() - 1);
      scene.instances[i].object_to_world = place(random);
      // Some leave for a place far away, and are who lies farthest for as long as they stay.
      if (random() % 16 == 0)
        scene.instances[i].object_to_world.m[random() % 3][3] = 30 * unit(random);
    }
    newest = prepare(scene, newest.get());
    most_moves = std::max(most_moves, expect_sound(*newest));
    hits += compare(scene, *newest, version % 10 == 0 ? 64 * 32 : 64, random);
    if (HasFailure()) return;
  }
  EXPECT_GT(most_moves, 20u) << "the hierarchy was hardly ever edited";
  EXPECT_GT(hits, 10'000u);
}

TEST(MovedInstances, BuildNothingElse) {
  Random random(5);
  Scene scene = make_field(200, random);
  const std::uint64_t terrain = scene.meshes[0]->triangles.size();
  const std::uint64_t ball = scene.meshes[1]->triangles.size();
  const Prepared first = prepare(scene, nullptr);
  EXPECT_EQ(first->built_primitives(), scene.triangle_count());
  scene.instances[1].object_to_world.m[2][3] += 1;
  const Prepared second = prepare(scene, first.get());  // balls get a structure of their own
  EXPECT_LT(second->built_primitives(), scene.triangle_count());
  EXPECT_GE(second->built_primitives(), terrain + ball);
  scene.instances[3].object_to_world.m[2][3] += 1;
  const Prepared third = prepare(scene, second.get());
  EXPECT_EQ(third->built_primitives(), 1u);
  scene.lights.push_back({});
  EXPECT_TRUE(prepare(scene, third.get())->has_geometry_of(*third));
}

TEST(MovedInstances, BuildTheirHierarchyAnewAfterManyMoves) {
  Random random(6);
  Scene scene = make_field(40, random);
  Prepared newest = prepare(scene, nullptr);
  std::uint64_t whole = 0;
  for (int version = 0; version < 40; ++version) {
    scene.instances[1].object_to_world = place(random);
    newest = prepare(scene, newest.get());
    whole += expect_sound(*newest) == 0 ? 1u : 0u;
  }
  // The 20 balls and what is flattened stand in it: five moves, and the sixth builds it anew.
  EXPECT_EQ(whole, 7u);
  compare(scene, *newest, 64 * 16, random);
}

TEST(MovedInstances, OfMeshesThatStandOnceLeaveTheOthersAsTheyAre) {
  Random random(7);
  Scene scene = make_field(2, random);
  Prepared newest = prepare(scene, nullptr);
  EXPECT_TRUE(newest->impl().triangles.is_flat());
  for (int version = 0; version < 3; ++version) {
    scene.instances[2].object_to_world = place(random);
    newest = prepare(scene, newest.get());
    expect_sound(*newest);
    compare(scene, *newest, 64 * 16, random);
  }
  EXPECT_LE(newest->built_primitives(), 3u) << "the hierarchy over three things, and nothing else";
}

TEST(MovedInstances, AMeshThatChangesIsBuiltAlone) {
  Random random(8);
  Scene scene = make_field(6, random);
  Prepared newest = prepare(scene, nullptr);
  for (int version = 0; version < 4; ++version) {
    Mesh changed = *scene.meshes[2];
    changed.positions[static_cast<std::size_t>(version)].z += 0.5f;
    scene.meshes[2] = std::make_shared<const Mesh>(std::move(changed));
    newest = prepare(scene, newest.get());
    expect_sound(*newest);
    compare(scene, *newest, 64 * 16, random);
  }
  EXPECT_LE(newest->built_primitives(), scene.meshes[2]->triangles.size() + 7);
}

TEST(MovedInstances, WhereMostIsExchangedAllIsBuiltAsOne) {
  Random random(11);
  Scene scene = make_field(6, random);
  const Prepared first = prepare(scene, nullptr);
  scene.meshes[0] = std::make_shared<const Mesh>(test::make_terrain(30, 4));
  const Prepared second = prepare(scene, first.get());
  EXPECT_TRUE(second->impl().triangles.is_flat());
  EXPECT_EQ(second->built_primitives() + second->fitted_primitives(), scene.triangle_count());
  compare(scene, *second, 64 * 16, random);
}

// So many balls that they share a structure from the first version on.
Scene make_crowd(Random& random) {
  Scene scene = test::make_scene(test::make_icosphere(5));
  scene.instances.clear();
  for (int i = 0; i < 30; ++i) scene.instances.push_back({0, place(random)});
  return scene;
}

TEST(MovedInstances, OfACrowdAloneAreEditedFromTheFirstMoveOn) {
  Random random(11);
  Scene scene = make_crowd(random);
  Prepared newest = prepare(scene, nullptr);
  EXPECT_EQ(newest->built_primitives(), scene.meshes[0]->triangles.size() + 30);
  for (int version = 0; version < 2; ++version) {
    scene.instances[static_cast<std::size_t>(5 + version)].object_to_world = place(random);
    newest = prepare(scene, newest.get());
    EXPECT_EQ(newest->built_primitives(), 1u);
    EXPECT_EQ(expect_sound(*newest), static_cast<std::uint64_t>(version) + 1);
  }
  compare(scene, *newest, 64 * 8, random);
}

// The terrain is part of the hierarchy over all before the first move, and an instance behind it.
TEST(MovedInstances, OfACrowdOnATerrainHaveItsBounds) {
  Random random(12);
  Scene scene = make_crowd(random);
  scene.meshes.push_back(std::make_shared<const Mesh>(test::make_terrain(30, 3)));
  scene.instances.push_back({1, Transform{}});
  for (const float far : {0.0f, 40.0f}) {
    const Prepared first = prepare(scene, nullptr);
    scene.instances[7].object_to_world.m[0][3] = far;
    const Prepared second = prepare(scene, first.get());
    compare(scene, *second, 64 * 8, random);
    scene.instances[7].object_to_world.m[0][3] = 1;
    const Prepared third = prepare(scene, second.get());
    EXPECT_EQ(third->built_primitives(), 1u);
    compare(scene, *third, 64 * 8, random);
  }
}

TEST(MovedInstances, ThatComeAndGo) {
  Random random(9);
  Scene scene = make_field(12, random);
  Prepared newest = prepare(scene, nullptr);
  for (int version = 0; version < 12; ++version) {
    const auto at = static_cast<std::ptrdiff_t>(random() % (scene.instances.size() - 1));
    if (version % 3 == 2) {
      scene.instances.push_back({1, place(random)});
    } else {
      scene.instances.erase(scene.instances.begin() + at);
    }
    newest = prepare(scene, newest.get());
    compare(scene, *newest, 64 * 8, random);
    if (HasFailure()) return;
  }
}

// A lamp's triangles are lamps each, so it stays flattened, and its light moves with it.
TEST(MovedInstances, LampsStayFlattened) {
  Random random(10);
  Scene scene = make_field(8, random);
  scene.materials.push_back(scene.materials[0]);
  scene.materials.back().emission = {3, 2, 1};
  Mesh lamp = test::make_icosphere(1);
  lamp.materials = {static_cast<std::uint32_t>(scene.materials.size() - 1)};
  scene.meshes.push_back(std::make_shared<const Mesh>(std::move(lamp)));
  scene.instances.push_back({3, place(random)});
  Prepared newest = prepare(scene, nullptr);
  for (int version = 0; version < 4; ++version) {
    // A ball moves first, so that what is flattened has a structure of its own when the lamp does.
    (version == 0 ? scene.instances[1] : scene.instances.back()).object_to_world = place(random);
    newest = prepare(scene, newest.get());
    const Prepared flat = prepare(scene, nullptr, Instancing::kNever);
    const auto &wanted = flat->impl().lights.emitters, &found = newest->impl().lights.emitters;
    ASSERT_EQ(wanted.size(), found.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      EXPECT_EQ(wanted[i].triangle, found[i].triangle);
      EXPECT_EQ(wanted[i].a, found[i].a);
    }
    compare(scene, *newest, 64 * 8, random);
  }
}

}  // namespace
}  // namespace tessera::core
