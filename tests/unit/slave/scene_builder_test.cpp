// The builder's queue under an animation that is faster than it.
#include "slave/scene_builder.h"

#include <gtest/gtest.h>

#include "common/scene/scene.h"

namespace tessera::slave {
namespace {

// Takes much longer to decode than the queue takes to fill.
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
  for (std::size_t i = 0; i < SceneBuilder::kQueueMax; ++i) {
    EXPECT_TRUE(builder.try_push({1, version + i, scene})) << i;
  }
}

}  // namespace
}  // namespace tessera::slave
