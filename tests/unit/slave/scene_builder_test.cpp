// SPDX-License-Identifier: Apache-2.0
// The builder's queue under an animation that is faster than the builder.
#include "slave/scene_builder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <thread>

#include "common/base/bounded_queue.h"
#include "common/scene/scene.h"
#include "slave/core/scene/prepared_scene_impl.h"

namespace tessera::slave {
namespace {

// A scene that takes much longer to decode than the queue takes to fill.
EncodedScene slow_scene() {
  constexpr std::uint32_t kTriangles = 200'000;
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh->triangles.assign(kTriangles, {0, 1, 2});
  mesh->materials.assign(kTriangles, 0);
  Scene scene;
  scene.meshes = {mesh};
  scene.materials.emplace_back();
  scene.instances.emplace_back();
  return SceneEncoder().encode(scene);
}

TEST(SceneBuilderTest, RetiredScenesMakeRoomAtOnce) {
  SceneBuilder builder({1, nullptr, {}}, [](const BuildOutcome&) {});
  const EncodedScene scene = slow_scene();
  SceneVersion version = 1;
  while (builder.try_push({1, version, scene})) ++version;  // the first ones are in work or wait
  builder.retire(1, version);
  for (std::size_t i = 0; i < BuildOrder::kWaitingMax; ++i) {
    EXPECT_TRUE(builder.try_push({1, version + i, scene})) << i;
  }
}

// A slave builds its tree again for another place of a mesh, not for other lights and materials.
TEST(SceneBuilderTest, WhatDoesNotMoveIsNotBuiltAgain) {
  BoundedQueue<BuildOutcome> outcomes(4);
  SceneBuilder builder({1, nullptr, {}},
                       [&](BuildOutcome outcome) { ASSERT_TRUE(outcomes.try_push(outcome)); });
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  mesh.materials = {0};
  Scene scene;
  scene.meshes = {std::make_shared<const Mesh>(mesh)};
  scene.materials.emplace_back();
  scene.instances.emplace_back();
  SceneEncoder encoder;
  const auto built = [&](SceneVersion version) {
    EXPECT_TRUE(builder.try_push({1, version, encoder.encode(scene)}));
    auto outcome = outcomes.pop();
    EXPECT_TRUE(outcome && outcome->scene.is_ok());
    return *outcome->scene;
  };
  const auto first = built(1);
  scene.lights.emplace_back();
  scene.materials[0].emission = {1, 1, 1};
  const auto lit = built(2);
  EXPECT_EQ(first->impl().geometry, lit->impl().geometry);
  EXPECT_EQ(lit->impl().lights.lights.size(), 1u);
  EXPECT_EQ(lit->impl().lights.emitters.size(), 2u);
  scene.instances[0].object_to_world.m[0][3] = 1;
  EXPECT_NE(first->impl().geometry, built(3)->impl().geometry);
}

// As when a light moves from frame to frame, each version is retired, and no frame holds it any
// more, before the next one with the same meshes comes.
TEST(SceneBuilderTest, ARetiredSceneStillServesTheNextUntilItIsForgotten) {
  BoundedQueue<BuildOutcome> outcomes(4);
  SceneBuilder builder({1, nullptr, {}},
                       [&](BuildOutcome outcome) { ASSERT_TRUE(outcomes.try_push(outcome)); });
  const EncodedScene scene = slow_scene();
  const auto built_primitives = [&](SceneVersion version) {
    EXPECT_TRUE(builder.try_push({1, version, scene}));
    const auto outcome = outcomes.pop();
    EXPECT_TRUE(outcome && outcome->scene.is_ok());
    builder.retire(1, version + 1);
    return outcome->built_primitives;
  };
  EXPECT_EQ(built_primitives(1), 200'000u);
  EXPECT_EQ(built_primitives(2), 0u);
  EXPECT_EQ(built_primitives(3), 0u);
  builder.forget_newest();
  EXPECT_EQ(built_primitives(4), 200'000u);
}

// The thread that waits is in the middle of its build; a frame that waits for the scene has no tile
// before it is built, so all render threads are without one.
TEST(SceneBuilderTest, ABuildStandsWhileAllThreadsRenderAndGoesOnWhenOneIsFree) {
  BoundedQueue<BuildOutcome> outcomes(4);
  constexpr int kThreads = 2;
  SceneBuilder builder(
      {kThreads, nullptr, {}},
      [&](BuildOutcome outcome) { ASSERT_TRUE(outcomes.try_push(outcome)); },
      BuildPace(kThreads, 0));
  const EncodedScene scene = slow_scene();
  SceneVersion version = 0;
  for (const int rendering : {0, kThreads - 1}) {
    builder.set_rendering(kThreads);
    EXPECT_TRUE(builder.try_push({1, ++version, scene}));
    while (builder.waiting_threads() == 0) std::this_thread::yield();
    builder.set_rendering(rendering);
    const auto outcome = outcomes.pop();
    EXPECT_TRUE(outcome && outcome->scene.is_ok()) << rendering;
    builder.forget_newest();
  }
  builder.set_rendering(kThreads);
  EXPECT_TRUE(builder.try_push({1, ++version, scene}));
  while (builder.waiting_threads() == 0) std::this_thread::yield();
  builder.retire(1, version + 1);  // what nobody needs any more ends, and so does its thread
  EXPECT_FALSE(outcomes.pop()->scene.is_ok());
}

// A thread cannot take back a lower priority, and others on the machine would go first for good.
TEST(SceneBuilderTest, ABuildBesideRenderingKeepsItsPriority) {
  const auto priority = [] { return getpriority(PRIO_PROCESS, 0); };  // of the calling thread
  BoundedQueue<int> priorities(4);
  SceneBuilder builder({1, nullptr, {}},
                       [&](const BuildOutcome&) { ASSERT_TRUE(priorities.try_push(priority())); });
  builder.set_rendering(1);
  EXPECT_TRUE(builder.try_push({1, 1, slow_scene()}));
  EXPECT_EQ(*priorities.pop(), priority());
}

}  // namespace
}  // namespace tessera::slave
