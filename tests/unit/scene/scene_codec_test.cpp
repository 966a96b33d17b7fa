// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "common/scene/block_chunks.h"
#include "common/scene/scene_footprint.h"
#include "common/scene/vertex_normals.h"
#include "tests/support/small_scene.h"

namespace tessera {
namespace {

void expect_equal(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t i = 0; i < a.meshes.size(); ++i) EXPECT_EQ(*a.meshes[i], *b.meshes[i]);
  ASSERT_EQ(a.textures.size(), b.textures.size());
  for (std::size_t i = 0; i < a.textures.size(); ++i) EXPECT_EQ(*a.textures[i], *b.textures[i]);
  EXPECT_EQ(a.materials, b.materials);
  EXPECT_EQ(a.instances, b.instances);
  EXPECT_EQ(a.lights, b.lights);
  EXPECT_EQ(a.environment, b.environment);
  EXPECT_EQ(a.background, b.background);
  EXPECT_EQ(a.cameras, b.cameras);
  ASSERT_EQ(a.environment_map == nullptr, b.environment_map == nullptr);
  if (a.environment_map) {
    EXPECT_EQ(*a.environment_map, *b.environment_map);
  }
  ASSERT_EQ(a.camera.has_value(), b.camera.has_value());
  if (a.camera) {
    EXPECT_EQ(a.camera->eye, b.camera->eye);
  }
}

SceneBlock block_of(std::vector<std::byte> bytes) {
  SceneBlock block;
  block.digest = sha256(bytes);
  block.bytes = block_bytes_of(std::move(bytes));
  return block;
}

TEST(SceneCodec, RoundTripKeepsEveryValue) {
  const Scene scene = test::make_small_scene();
  SceneEncoder encoder;
  SceneDecoder decoder;
  auto decoded = decoder.decode(encoder.encode(scene));
  ASSERT_TRUE(decoded.is_ok()) << decoded.status().message();
  expect_equal(scene, *decoded);
}

TEST(SceneCodec, TexturesOf16BitsKeepThem) {
  Scene scene = test::make_small_scene();
  auto deep = std::make_shared<Texture>();
  deep->width_px = deep->height_px = 1;
  deep->rgba16 = {65535, 1, 256, 40000};
  scene.textures[1] = deep;
  SceneEncoder encoder;
  SceneDecoder decoder;
  auto decoded = decoder.decode(encoder.encode(scene));
  ASSERT_TRUE(decoded.is_ok()) << decoded.status().message();
  EXPECT_EQ(*decoded->textures[1], *deep);
}

TEST(SceneCodec, AVersionThatMovesOneMeshChangesThatBlockAndTheRootAlone) {
  Scene scene = test::make_small_scene();
  SceneEncoder encoder;
  const EncodedScene before = encoder.encode(scene);
  auto moved = std::make_shared<Mesh>(*scene.meshes[0]);
  moved->positions[0].z = 0.25f;
  scene.meshes[0] = moved;
  const EncodedScene after = encoder.encode(scene);
  std::set<std::string> known;
  for (const SceneBlock& block : before.blocks) known.insert(block.digest.hex());
  int fresh = 0;
  for (const SceneBlock& block : after.blocks) fresh += known.contains(block.digest.hex()) ? 0 : 1;
  EXPECT_EQ(fresh, 1) << "the root names blocks by index, so only the mesh is new";
  EXPECT_NE(before.digest(), after.digest());
  SceneEncoder stranger;
  EXPECT_EQ(stranger.encode(scene).digest(), after.digest());
}

TEST(SceneCodec, WhatIsAtAnotherPlaceOrTwiceThereIsNotEncodedAgain) {
  Scene scene = test::make_small_scene();
  const Mesh mesh = *scene.meshes[0];
  while (scene.meshes.size() < 6) scene.meshes.push_back(std::make_shared<Mesh>(mesh));
  SceneEncoder encoder;
  const EncodedScene before = encoder.encode(scene);
  std::map<const Mesh*, const void*> bytes_of;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    bytes_of[scene.meshes[m].get()] = before.blocks[m + 1].bytes.get();
  const auto expect_known = [&] {
    const EncodedScene now = encoder.encode(scene);
    SceneEncoder stranger;
    EXPECT_EQ(stranger.encode(scene).digest(), now.digest());
    for (std::size_t m = 0; m < scene.meshes.size(); ++m)
      EXPECT_EQ(now.blocks[m + 1].bytes.get(), bytes_of.at(scene.meshes[m].get())) << m;
  };
  std::rotate(scene.meshes.begin(), scene.meshes.begin() + 2, scene.meshes.end());
  expect_known();
  scene.meshes.push_back(scene.meshes[1]);
  expect_known();
  scene.meshes.erase(scene.meshes.begin() + 3, scene.meshes.begin() + 5);
  expect_known();
  std::weak_ptr<const Mesh> gone = scene.meshes[2];
  scene.meshes = {scene.meshes[0]};
  for (Instance& instance : scene.instances) instance.mesh = 0;
  expect_known();
  EXPECT_TRUE(gone.expired()) << "what a version does not use is forgotten";
}

// Returns: how many bytes a peer that has one version lacks of the other: chunks, and lists of
// them.
std::uint64_t bytes_to_send(const EncodedScene& before, const EncodedScene& after) {
  std::uint64_t bytes = 0;
  for (std::size_t b = 0; b < after.blocks.size(); ++b) {
    const SceneBlock &now = after.blocks[b], &then = before.blocks[b];
    if (now.digest == then.digest) continue;
    if (!now.chunks || !then.chunks) {
      bytes += now.bytes->size();
      continue;
    }
    bytes += now.chunks->size() * sizeof(Digest);
    for (std::uint32_t c = 0; c < now.chunks->size(); ++c) {
      const bool is_known = c < then.chunks->size() && (*now.chunks)[c] == (*then.chunks)[c];
      if (!is_known) bytes += chunk_bytes(now.bytes->size(), c);
    }
  }
  return bytes;
}

TEST(SceneCodec, AMovedInstanceOfTenThousandTakesOneChunk) {
  Scene scene = test::make_small_scene();
  while (scene.instances.size() < 10'000) scene.instances.push_back(scene.instances[0]);
  SceneEncoder encoder;
  const EncodedScene before = encoder.encode(scene);
  SceneDecoder decoder;
  const auto decoded = decoder.decode(before);
  ASSERT_TRUE(decoded.is_ok());
  EXPECT_EQ(decoded->instances, scene.instances);
  // An instance takes 56 bytes, so every 1,170th would lie in two chunks.
  for (std::size_t i = 1; i < scene.instances.size(); i += i < 1500 ? 1 : 97) {
    const Instance was = scene.instances[i];
    for (std::size_t a = 0; a < 3; ++a) {
      for (float& value : scene.instances[i].object_to_world.m[a]) value += 1.5f;
    }
    EXPECT_LE(bytes_to_send(before, encoder.encode(scene)), 70u * 1024) << "instance " << i;
    scene.instances[i] = was;
  }
}

// A sheet whose normals follow from its positions.
Mesh make_sheet(std::uint32_t side, float phase) {
  Mesh sheet;
  for (std::uint32_t i = 0; i < (side + 1) * (side + 1); ++i) {
    const auto x = static_cast<float>(i % (side + 1)), y = static_cast<float>(i / (side + 1));
    sheet.positions.push_back({x, std::sin(0.3f * x + 0.2f * y + phase), y});
  }
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const std::uint32_t at = i / side * (side + 1) + i % side;
    sheet.triangles.push_back({at, at + side + 1, at + 1});
    sheet.triangles.push_back({at + 1, at + side + 1, at + side + 2});
  }
  sheet.materials = {0};
  sheet.normals = vertex_normals(sheet);
  return sheet;
}

TEST(SceneCodec, NormalsThatFollowFromPositionsDoNotTravelAndAreTheSameBits) {
  Scene scene = test::make_small_scene();
  const auto show = [&](const Mesh& mesh) {
    scene.meshes[0] = std::make_shared<const Mesh>(mesh);
    return SceneEncoder().encode(scene);
  };
  const Mesh sheet = make_sheet(256, 0);
  const EncodedScene before = show(sheet), after = show(make_sheet(256, 1));
  const auto decoded = SceneDecoder().decode(before);
  ASSERT_TRUE(decoded.is_ok());
  EXPECT_EQ(*decoded->meshes[0], sheet);
  const std::uint64_t positions = sheet.positions.size() * sizeof(Vec3f);
  EXPECT_LE(bytes_to_send(before, after), positions + 2048) << "the positions and lists of digests";
  Mesh other = sheet;
  other.normals[7] = {0, 0, 1};
  const auto differs = SceneDecoder().decode(show(other));
  ASSERT_TRUE(differs.is_ok());
  EXPECT_EQ(*differs->meshes[0], other) << "normals of their own travel";
  other.normals.clear();
  const auto flat = SceneDecoder().decode(show(other));
  ASSERT_TRUE(flat.is_ok());
  EXPECT_TRUE(flat->meshes[0]->normals.empty());
}

TEST(SceneCodec, UnchangedMeshesAreSharedBetweenDecodedVersions) {
  const Scene scene = test::make_small_scene();
  SceneEncoder encoder;
  SceneDecoder decoder;
  auto first = decoder.decode(encoder.encode(scene));
  auto second = decoder.decode(encoder.encode(scene));
  ASSERT_TRUE(first.is_ok() && second.is_ok());
  EXPECT_EQ(first->meshes[0].get(), second->meshes[0].get());
}

TEST(SceneCodec, TruncatedBlocksAreRefusedAtEveryLength) {
  SceneEncoder encoder;
  const EncodedScene whole = encoder.encode(test::make_small_scene());
  for (std::size_t b = 0; b < whole.blocks.size(); ++b) {
    const std::span<const std::byte> bytes = *whole.blocks[b].bytes;
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      EncodedScene cut = whole;
      cut.blocks.set(
          b, block_of({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)}));
      SceneDecoder decoder;
      EXPECT_FALSE(decoder.decode(cut).is_ok()) << "block " << b << " cut to " << length;
    }
  }
}

TEST(SceneCodec, AnyFlippedByteIsRefusedOrGivesAValidScene) {
  SceneEncoder encoder;
  const EncodedScene whole = encoder.encode(test::make_small_scene());
  for (std::size_t b = 0; b < whole.blocks.size(); ++b) {
    const std::span<const std::byte> sound = *whole.blocks[b].bytes;
    for (std::size_t i = 0; i < sound.size(); ++i) {
      std::vector<std::byte> bytes(sound.begin(), sound.end());
      bytes[i] ^= std::byte{0xff};
      EncodedScene damaged = whole;
      damaged.blocks.set(b, block_of(std::move(bytes)));
      SceneDecoder decoder;
      auto decoded = decoder.decode(damaged);  // must neither crash nor take memory without bound
      if (!decoded.is_ok()) {
        EXPECT_FALSE(decoded.status().message().empty());
      }
    }
  }
}

TEST(SceneCodec, MipLevelsOfTexturesAreReckoned) {
  Scene scene = test::make_small_scene();
  const std::uint64_t small = index_bytes_of(SceneEncoder().encode(scene));
  auto texture = std::make_shared<Texture>();
  texture->width_px = texture->height_px = 256;
  texture->rgba.resize(4 * 256 * 256);
  scene.textures = {texture};
  const std::uint64_t large = index_bytes_of(SceneEncoder().encode(scene));
  EXPECT_GE(large - small, 4 * texture->rgba.size() / 3 - 256);
  EXPECT_LE(large - small, 4 * texture->rgba.size() / 3 + 256);
}

TEST(SceneCodec, AMissingBlockIsRefused) {
  SceneEncoder encoder;
  EncodedScene scene = encoder.encode(test::make_small_scene());
  std::vector<SceneBlock> blocks(scene.blocks.begin(), scene.blocks.end());
  blocks.pop_back();
  scene.blocks = std::move(blocks);
  SceneDecoder decoder;
  EXPECT_FALSE(decoder.decode(scene).is_ok());
  EXPECT_FALSE(decoder.decode(EncodedScene{}).is_ok());
}

}  // namespace
}  // namespace tessera
