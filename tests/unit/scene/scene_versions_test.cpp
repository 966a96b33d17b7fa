// SPDX-License-Identifier: Apache-2.0
// What is kept from version to version of a scene of many objects changes nothing: blocks, digests,
// footprints and decoded scenes are those that a stranger makes of the same version.
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <utility>

#include "common/scene/scene_footprint.h"
#include "common/scene/scene_summary.h"
#include "tests/support/small_scene.h"

namespace tessera {
namespace {

constexpr std::size_t kMeshes = 700;  // three chunks of a table of blocks

class ChangingScene {
 public:
  explicit ChangingScene(unsigned seed) : scene(test::make_small_scene()), random_(seed) {
    while (scene.meshes.size() < kMeshes) add_object();
  }

  void change() {
    for (auto changes = random_() % 4; changes > 0; --changes) change_once();
  }

  Scene scene;

 private:
  void add_object() {
    scene.meshes.push_back(some_mesh());
    Instance instance;
    instance.mesh = static_cast<std::uint32_t>(scene.meshes.size() - 1);
    scene.instances.push_back(instance);
  }
  std::shared_ptr<const Mesh> some_mesh() {
    Mesh mesh = *scene.meshes[0];
    for (Vec3f& p : mesh.positions) p.x += static_cast<float>(random_() % 1000);
    mesh.triangles.resize(1 + random_() % mesh.triangles.size());
    mesh.materials.resize(1);
    return std::make_shared<const Mesh>(std::move(mesh));
  }
  void change_once() {
    const std::size_t at = 1 + random_() % (scene.meshes.size() - 1);
    switch (random_() % 6) {
      case 0:
        scene.meshes[at] = some_mesh();
        break;
      case 1:
        add_object();
        break;
      case 2:  // the last object goes
        std::erase_if(scene.instances, [&](const Instance& instance) {
          return instance.kind == ObjectKind::kMesh && instance.mesh + 1 == scene.meshes.size();
        });
        scene.meshes.pop_back();
        break;
      case 3:
        std::swap(scene.meshes[at], scene.meshes[1]);
        break;
      default:
        scene.instances[random_() % scene.instances.size()].object_to_world.m[0][3] += 1;
    }
  }

  std::mt19937 random_;
};

void expect_same(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t m = 0; m < a.meshes.size(); ++m) ASSERT_EQ(*a.meshes[m], *b.meshes[m]) << m;
  ASSERT_EQ(a.instances, b.instances);
  ASSERT_EQ(a.textures.size(), b.textures.size());
}

void run(unsigned seed) {
  ChangingScene changing(seed);
  SceneEncoder encoder;
  SceneDecoder decoder;
  SceneFootprint footprint;
  SceneSummarizer summarizer;
  std::shared_ptr<const Scene> held;
  for (int version = 0; version < 30; ++version) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", version " + std::to_string(version));
    const EncodedScene encoded = encoder.encode(changing.scene);
    const EncodedScene anew = SceneEncoder().encode(changing.scene);
    ASSERT_EQ(encoded.blocks.size(), anew.blocks.size());
    for (std::size_t b = 0; b < anew.blocks.size(); ++b)
      ASSERT_EQ(encoded.blocks[b].digest, anew.blocks[b].digest) << b;
    const SceneSummary summary = summarizer.of(encoded.blocks);
    EXPECT_EQ(summary.digest, anew.digest());
    std::vector<Digest> digests;
    for (const SceneBlock& block : anew.blocks) digests.push_back(block.digest);
    EXPECT_EQ(summary.digest, scene_digest(digests));
    EXPECT_EQ(summary.bytes, anew.total_bytes());
    EXPECT_EQ(footprint.index_bytes_of(encoded), index_bytes_of(anew));
    auto decoded = decoder.decode_shared(encoded);
    ASSERT_TRUE(decoded.is_ok()) << decoded.status().message();
    const auto stranger = SceneDecoder().decode(anew);
    ASSERT_TRUE(stranger.is_ok());
    ASSERT_NO_FATAL_FAILURE(expect_same(**decoded, *stranger));
    held = version % 7 == 3 ? nullptr : *decoded;  // now and then nothing of it is kept
    changing.change();
  }
}

TEST(SceneVersions, WhatIsKeptChangesNothing) {
  for (unsigned seed = 0; seed < 6; ++seed) ASSERT_NO_FATAL_FAILURE(run(seed));
}

TEST(SceneVersions, AnInstanceOfAMeshThatIsGoneIsRefused) {
  Scene scene = test::make_small_scene();
  scene.meshes.push_back(scene.meshes[0]);
  Instance instance;
  instance.mesh = static_cast<std::uint32_t>(scene.meshes.size() - 1);
  scene.instances.push_back(instance);
  SceneValidator validator;
  ASSERT_TRUE(validator.validate(scene).is_ok());
  scene.meshes.pop_back();
  EXPECT_FALSE(validator.validate(scene).is_ok());
}

}  // namespace
}  // namespace tessera
