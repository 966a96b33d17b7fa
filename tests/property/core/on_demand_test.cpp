// SPDX-License-Identifier: Apache-2.0
// Property: a scene whose meshes are built when rays meet them has the bits of the scene built
// beforehand, on every instruction set and whatever the threads; each mesh is built once, and only
// if a ray has met it; what cannot be built is told and answers nothing.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <latch>
#include <new>
#include <random>
#include <thread>

#include "slave/core/primitive/instance/mesh_slot.h"
#include "slave/core/primitive/instance/mesh_slot_abi.h"
#include "slave/core/ray/met_builds.h"
#include "slave/core/scene/prepared_scene_impl.h"
#include "tests/support/flattened_twin.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace tessera::core {
namespace {

using Prepared = std::shared_ptr<const PreparedScene>;

Prepared prepare(const Scene& scene, bool is_on_demand, const PreparedScene* other = nullptr) {
  BuildOptions options;
  options.is_on_demand = is_on_demand;
  options.other = other;
  auto built = PreparedScene::build(scene, options);
  EXPECT_TRUE(built.is_ok());
  return *built;
}

// Rooms in a row, each a mesh of its own; the first stands twice, turned.
Scene row_of_rooms() {
  Scene scene = test::make_scene(test::make_icosphere(3));
  scene.instances.clear();
  for (std::uint32_t i = 0; i < 6; ++i) {
    if (i > 0) {
      const Mesh mesh = i % 2 == 0 ? test::make_icosphere(2) : test::make_torus(40, 20);
      scene.meshes.push_back(std::make_shared<const Mesh>(mesh));
    }
    Instance instance{i, {}};
    instance.object_to_world.m[0][3] = 4 * static_cast<float>(i);
    scene.instances.push_back(instance);
  }
  Instance turned{0, {}};
  turned.object_to_world.m = {{{0.6f, -0.8f, 0, 2}, {0.8f, 0.6f, 0, 5}, {0, 0, 1, 0.1f}}};
  scene.instances.push_back(turned);
  return scene;
}

TEST(OnDemand, HasTheBitsOfWhatIsBuiltBeforehand) {
  const Scene scene = row_of_rooms();
  std::mt19937 random(test::seed(1));
  const Prepared flat = prepare(scene, false), met = prepare(scene, true);
  EXPECT_EQ(flat->impl().index.bounds().lower, met->impl().index.bounds().lower);
  EXPECT_EQ(flat->impl().index.bounds().upper, met->impl().index.bounds().upper);
  EXPECT_EQ(flat->degenerate_count(), met->degenerate_count());
  const auto rays = test::rays_around(flat->impl().triangles, 3000, random);
  EXPECT_GT(test::compare_with_flattened(*flat, *met, rays), 500u);
}

// A ray along -y through the room at `x`.
void cast_into(const PreparedScene& scene, float x) {
  const std::vector<CastRay> rays{{{x, 9, 0.05f}, {0, -1, 0}, 0, Bounds3f::kInf}};
  std::vector<CastHit> hits(1);
  cast_rays(scene, rays, {Isa::kScalar, 1, 1, false}, hits);
}

TEST(OnDemand, BuildsWhatRaysMeetOnce) {
  const Scene scene = row_of_rooms();
  const Prepared met = prepare(scene, true);
  const std::uint64_t none = met->built_primitives(), bytes = met->memory_bytes();
  EXPECT_LE(none, scene.instances.size());
  cast_into(*met, 8);
  const std::uint64_t one = met->built_primitives();
  EXPECT_EQ(one - none, scene.meshes[2]->triangles.size());
  EXPECT_GT(met->memory_bytes(), bytes);
  cast_into(*met, 8);
  EXPECT_EQ(met->built_primitives(), one);
  // A version in which something moves keeps what was met, and has not built it.
  Scene later = scene;
  later.instances[5].object_to_world.m[0][3] += 1;
  const Prepared next = prepare(later, true, met.get());
  const std::uint64_t moved = next->built_primitives();
  EXPECT_LE(moved, 2 * scene.instances.size());
  cast_into(*next, 8);
  EXPECT_EQ(next->built_primitives(), moved);
  cast_into(*next, 0);
  EXPECT_GT(next->built_primitives(), moved);
}

std::shared_ptr<const Mesh> ball() { return std::make_shared<const Mesh>(test::make_icosphere(2)); }

TEST(MeshSlot, IsBuiltByOneOfManyThreads) {
  std::atomic<int> builds = 0;
  const auto mesh = ball();
  MeshSlot<8> slot(mesh, [&] {
    ++builds;
    return index_mesh<8>(*mesh, {1, nullptr});
  });
  const MeshShape<8> shape = slot.shape();
  EXPECT_TRUE(is_slot(shape));
  const auto wanted = *index_mesh<8>(*mesh, {1, nullptr});
  std::latch start(8);
  std::vector<std::jthread> threads;
  std::atomic<int> sound = 0;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      start.arrive_and_wait();
      const MeshShape<8>& met = met_mesh(shape);
      if (met.nodes != nullptr && met.block_count == wanted->shape().block_count) ++sound;
    });
  }
  threads.clear();
  EXPECT_EQ(builds, 1);
  EXPECT_EQ(sound, 8);
}

TEST(MeshSlot, IsLeftWhileAnotherThreadBuilds) {
  const auto mesh = ball();
  std::latch is_begun(1), may_end(1);
  MeshSlot<8> slot(mesh, [&] {
    is_begun.count_down();
    may_end.wait();
    return index_mesh<8>(*mesh, {1, nullptr});
  });
  std::jthread first([&] { slot.meet(); });
  is_begun.wait();
  {
    MetBuilds met(MetBuilds::WhenBusy::kLeaveTile);
    EXPECT_FALSE(MetBuilds::is_to_leave());
    EXPECT_EQ(slot.meet().nodes, nullptr);
    EXPECT_TRUE(met.has_left());
    EXPECT_TRUE(MetBuilds::is_to_leave());
  }
  EXPECT_FALSE(MetBuilds::is_to_leave());
  may_end.count_down();
  MetBuilds met(MetBuilds::WhenBusy::kWait);
  EXPECT_NE(slot.meet().nodes, nullptr);
  EXPECT_FALSE(met.has_left());
}

TEST(MeshSlot, TellsWhatCannotBeBuilt) {
  MeshSlot<8> refused(ball(), [] { return Status::resource_exhausted("no room"); });
  MeshSlot<8> thrown(
      ball(), []() -> Result<std::shared_ptr<const MeshIndex<8>>> { throw std::bad_alloc(); });
  for (MeshSlot<8>* const slot : {&refused, &thrown}) {
    for (int time = 0; time < 2; ++time) {
      MetBuilds met(MetBuilds::WhenBusy::kLeaveTile);
      EXPECT_EQ(slot->meet().nodes, nullptr);
      EXPECT_EQ(met.failure().code(), StatusCode::kResourceExhausted);
      EXPECT_TRUE(MetBuilds::is_to_leave());
    }
    EXPECT_TRUE(slot->has_failed());
    EXPECT_EQ(slot->built(), nullptr);
  }
  // What is met within a part of the work is told to the whole.
  MetBuilds whole(MetBuilds::WhenBusy::kLeaveTile);
  {
    MetBuilds part(MetBuilds::WhenBusy::kWait);
    refused.meet();
  }
  EXPECT_EQ(whole.failure().message(), "no room");
}

}  // namespace
}  // namespace tessera::core
