// SPDX-License-Identifier: Apache-2.0
// Freeform surfaces in blocks of their own.
#include <gtest/gtest.h>

#include "common/scene/scene_codec.h"
#include "common/scene/scene_footprint.h"
#include "common/scene/surface_sample.h"
#include "common/scene/validate.h"
#include "tests/support/seed.h"
#include "tests/support/surface_scene.h"

namespace tessera {
namespace {

std::shared_ptr<const PatchSurface> shared(PatchSurface surface) {
  return std::make_shared<const PatchSurface>(std::move(surface));
}

// A sheet of side * side bicubic patches without shared points.
PatchSurface sheet(int side) {
  PatchSurface surface;
  surface.materials = {0};
  for (int p = 0; p < side * side; ++p) {
    surface.patches.push_back({3, 3, 0, 0});
    for (int i = 0; i < 16; ++i) {
      const int x = 3 * (p % side) + i % 4, y = 3 * (p / side) + i / 4;
      surface.numbers.insert(surface.numbers.end(), {static_cast<float>(x), static_cast<float>(y),
                                                     static_cast<float>((x * y) % 7)});
    }
  }
  return surface;
}

Scene scene_of(PatchSurface surface) {
  Scene scene;
  scene.materials.resize(1);
  scene.surfaces = {shared(std::move(surface))};
  scene.instances = {{0, {}, ObjectKind::kPatchSurface}};
  return scene;
}

// Of the chunks of block `index`, those that differ between two versions.
std::size_t chunks_changed(const EncodedScene& before, const EncodedScene& after,
                           std::size_t index) {
  const ChunkDigests &then = *before.blocks[index].chunks, &now = *after.blocks[index].chunks;
  EXPECT_EQ(then.size(), now.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < now.size(); ++i) count += then[i] == now[i] ? 0 : 1;
  return count;
}

TEST(SurfaceCodec, RoundTripKeepsEveryValue) {
  const Scene scene = test::make_surface_scene();
  SceneDecoder decoder;
  const auto decoded = decoder.decode(SceneEncoder().encode(scene));
  ASSERT_TRUE(decoded.is_ok()) << decoded.status().message();
  ASSERT_EQ(decoded->surfaces.size(), scene.surfaces.size());
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
    EXPECT_EQ(*decoded->surfaces[i], *scene.surfaces[i]);
  EXPECT_EQ(decoded->instances, scene.instances);
  ASSERT_EQ(decoded->meshes.size(), scene.meshes.size());
  EXPECT_EQ(*decoded->meshes[1], *scene.meshes[1]);
  ASSERT_EQ(decoded->textures.size(), scene.textures.size());
  EXPECT_EQ(*decoded->textures[1], *scene.textures[1]);
  EXPECT_EQ(decoded->patch_count(), 5u);
  EXPECT_EQ(decoded->triangle_count(), test::make_small_scene().triangle_count());
}

TEST(SurfaceCodec, RandomSurfacesComeBackBitByBit) {
  std::mt19937 random(test::seed(20261125));
  for (int n = 0; n < 300; ++n) {
    SCOPED_TRACE("surface " + std::to_string(n));
    const Scene scene = scene_of(test::make_random_surface(random, 6));
    const Status status = validate_scene(scene);
    ASSERT_TRUE(status.is_ok()) << status.message();
    const EncodedScene encoded = SceneEncoder().encode(scene);
    SceneDecoder decoder;
    const auto decoded = decoder.decode(encoded);
    ASSERT_TRUE(decoded.is_ok()) << decoded.status().message();
    EXPECT_EQ(*decoded->surfaces[0], *scene.surfaces[0]);
    EXPECT_EQ(SceneEncoder().encode(*decoded).digest(), encoded.digest());
  }
}

// Points all over the block are moved, and all those that lie in two chunks.
TEST(SurfaceCodec, AMovedControlPointTakesTheChunkInWhichItLies) {
  Scene scene = scene_of(sheet(60));
  SceneEncoder encoder;
  const EncodedScene before = encoder.encode(scene);
  ASSERT_GT(before.blocks[1].chunks->size(), 8u);
  const std::size_t first_byte = 8 + 8 + scene.surfaces[0]->patches.size() * sizeof(PatchForm) + 8;
  const auto chunk_of = [](std::size_t byte) { return byte / kSceneChunkBytes; };
  std::size_t in_two = 0;
  for (std::size_t point = 0; point < scene.surfaces[0]->numbers.size() / 3; ++point) {
    const std::size_t byte = first_byte + 12 * point;
    const bool is_in_two = chunk_of(byte) != chunk_of(byte + 11);
    if (point % 997 != 0 && !is_in_two) continue;
    in_two += is_in_two ? 1 : 0;
    PatchSurface moved = *scene.surfaces[0];
    for (std::size_t axis = 0; axis < 3; ++axis) moved.numbers[3 * point + axis] += 0.125f;
    Scene version = scene;
    version.surfaces[0] = shared(std::move(moved));
    const EncodedScene after = encoder.encode(version);
    EXPECT_EQ(after.blocks[0].digest, before.blocks[0].digest) << "the root names no content";
    EXPECT_EQ(chunks_changed(before, after, 1), is_in_two ? 2u : 1u) << "point " << point;
  }
  EXPECT_GT(in_two, 0u);
}

// Trims stand behind the points, which an array of 1 MiB and more ends with a chunk of its own.
TEST(SurfaceCodec, LoopsThatComeLeaveThePointsWhereTheyAre) {
  PatchSurface surface = sheet(80);
  const EncodedScene before = SceneEncoder().encode(scene_of(surface));
  surface.loop_counts.assign(surface.patches.size(), 0);
  surface.loop_counts[17] = 1;
  surface.segment_counts = {2};
  surface.degrees = {1, 1};
  surface.trim_points = {{0, 0, 1}, {1, 1, 1}};
  const EncodedScene after = SceneEncoder().encode(scene_of(surface));
  const ChunkDigests &then = *before.blocks[1].chunks, &now = *after.blocks[1].chunks;
  std::size_t same = 0;
  while (same < then.size() && same < now.size() && then[same] == now[same]) ++same;
  EXPECT_GE(same * kSceneChunkBytes, surface.numbers.size() * sizeof(float));
}

TEST(SurfaceCodec, UnchangedSurfacesAreSharedBetweenDecodedVersions) {
  Scene scene = test::make_surface_scene();
  SceneEncoder encoder;
  SceneDecoder decoder;
  const auto first = decoder.decode(encoder.encode(scene));
  PatchSurface other = *scene.surfaces[1];
  other.numbers[2] = 0.5f;
  scene.surfaces[1] = shared(std::move(other));
  const auto second = decoder.decode(encoder.encode(scene));
  ASSERT_TRUE(first.is_ok() && second.is_ok());
  EXPECT_EQ(first->surfaces[0].get(), second->surfaces[0].get());
  EXPECT_NE(first->surfaces[1].get(), second->surfaces[1].get());
}

TEST(SurfaceCodec, DamagedBlocksAreRefusedOrGiveAValidScene) {
  const EncodedScene whole = SceneEncoder().encode(test::make_surface_scene());
  const auto decoded_with = [&](std::size_t block, std::vector<std::byte> bytes) {
    EncodedScene damaged = whole;
    damaged.blocks.set(block, make_scene_block(std::move(bytes)));
    SceneDecoder decoder;
    return decoder.decode(damaged);
  };
  for (const std::size_t b : {std::size_t{0}, std::size_t{3}, std::size_t{4}}) {
    const std::span<const std::byte> sound = *whole.blocks[b].bytes;
    const std::vector<std::byte> bytes(sound.begin(), sound.end());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      EXPECT_FALSE(
          decoded_with(b, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(i)}).is_ok())
          << "block " << b << " cut to " << i;
      std::vector<std::byte> flipped = bytes;
      flipped[i] ^= std::byte{0xff};
      const auto decoded = decoded_with(b, std::move(flipped));
      EXPECT_TRUE(decoded.is_ok() || !decoded.status().message().empty());
    }
    std::vector<std::byte> longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(decoded_with(b, std::move(longer)).is_ok());
  }
}

TEST(SurfaceCodec, ABlockOfAnotherKindIsRefused) {
  EncodedScene scene = SceneEncoder().encode(test::make_surface_scene());
  const SceneBlock mesh = scene.blocks[2], surface = scene.blocks[3];  // the last, the first
  scene.blocks.set(2, surface);
  scene.blocks.set(3, mesh);
  SceneDecoder decoder;
  const auto decoded = decoder.decode(scene);
  ASSERT_FALSE(decoded.is_ok());
  EXPECT_EQ(decoded.status().message(), "scene block 2 (mesh) is malformed");
}

TEST(SurfaceCodec, PatchesAreReckonedPerInstance) {
  const Scene scene = test::make_surface_scene();
  const EncodedScene encoded = SceneEncoder().encode(scene);
  const PrimitiveCounts counts = primitive_counts_of(encoded);
  EXPECT_EQ(counts.triangles, scene.triangle_count());
  EXPECT_EQ(counts.patches, scene.patch_count());
  EXPECT_EQ(counts.numbers, 2 * (16u * 3 + 6 * 4) + 4 * 3);
  EXPECT_EQ(counts.trim_points, 2 * 8u);
  const std::uint64_t without = index_bytes_of(SceneEncoder().encode(test::make_small_scene()));
  EXPECT_EQ(index_bytes_of(encoded) - without,
            kIndexBytesOfThreads + counts.patches * kIndexBytesPerPatch +
                counts.numbers * 2 * sizeof(float) + counts.trim_points * kIndexBytesPerTrimPoint);
  EXPECT_GE(index_bytes_of(SceneEncoder().encode(scene_of(sheet(2)))), 4 * kIndexBytesPerPatch)
      << "a scene without triangles is reckoned, too";
}

TEST(SurfaceCodec, WhoeverCutsPatchesIsAskedForEachSurface) {
  const Scene scene = test::make_surface_scene();
  const EncodedScene encoded = SceneEncoder().encode(scene);
  std::uint64_t patches = 0, asked = 0;
  const std::uint64_t bytes = index_bytes_of(
      encoded, [&](const SceneBlock& surface, std::uint64_t copies, std::uint64_t all) {
        EXPECT_EQ(all, scene.patch_count());
        patches += copies * patches_of_surface(*surface.bytes);
        asked += copies;
        return 1'000'000 * copies;
      });
  EXPECT_EQ(patches, scene.patch_count());
  const std::uint64_t without = index_bytes_of(SceneEncoder().encode(test::make_small_scene()));
  EXPECT_EQ(bytes - without, kIndexBytesOfThreads + 1'000'000 * asked);
}

TEST(SurfaceSample, IsTheSurfaceWhereAllIsWantedAndElsePartOfIt) {
  std::mt19937 random(test::seed(8));
  for (int n = 0; n < 50; ++n) {
    const PatchSurface surface = test::make_random_surface(random, 40);
    Scene scene = scene_of(surface);
    const SceneBlock block = SceneEncoder().encode(scene).blocks.at(1);
    const auto all = sample_surface(*block.bytes, surface.patches.size());
    ASSERT_TRUE(all.has_value());
    EXPECT_EQ(all->patch_count, surface.patches.size());
    PatchSurface same = surface;
    same.materials = {0};
    EXPECT_EQ(all->surface, same);
    const auto some = sample_surface(*block.bytes, surface.patches.size() / 2);
    if (!some) continue;  // none was drawn
    EXPECT_LE(some->surface.numbers.size(), surface.numbers.size());
  }
}

TEST(SurfaceSample, DrawsAboutAsManyAsWanted) {
  PatchSurface many = sheet(1);
  for (int i = 1; i < 3200; ++i) {
    many.patches.push_back(many.patches[0]);
    for (std::size_t k = 0; k < many.patches[0].number_count(); ++k)
      many.numbers.push_back(many.numbers[k]);
  }
  const auto some = sample_surface(*SceneEncoder().encode(scene_of(many)).blocks.at(1).bytes, 320);
  ASSERT_TRUE(some.has_value());
  EXPECT_EQ(some->patch_count, many.patches.size());
  EXPECT_GT(some->surface.patches.size(), 240u);
  EXPECT_LT(some->surface.patches.size(), 400u);
}

TEST(SurfaceSample, DamagedBlocksHaveNone) {
  std::mt19937 random(test::seed(9));
  const PatchSurface surface = test::make_random_surface(random, 12);
  const SceneBlock block = SceneEncoder().encode(scene_of(surface)).blocks.at(1);
  std::vector<std::byte> bytes(block.bytes->begin(), block.bytes->end());
  for (std::size_t kept = 0; kept < bytes.size(); kept += 7)
    EXPECT_FALSE(sample_surface(std::span(bytes).first(kept), 100).has_value()) << kept;
  for (int n = 0; n < 2000; ++n) {  // any answer will do
    std::vector<std::byte> damaged = bytes;
    damaged[random() % damaged.size()] ^= static_cast<std::byte>(1u << random() % 8);
    static_cast<void>(sample_surface(damaged, n % 2 == 0 ? 100 : 3));
  }
}

TEST(SurfaceCodec, CursorsKnowWhereEachPatchLies) {
  std::mt19937 random(test::seed(7));
  for (int n = 0; n < 50; ++n) {
    const PatchSurface surface = test::make_random_surface(random, 8);
    PatchCursor at(surface);
    std::size_t patches = 0, points = 0;
    for (; at.is_any(); at.advance()) {
      EXPECT_EQ(at.patch(), patches++);
      for (std::size_t i = 0; i < at.form().point_count(); ++i, ++points)
        EXPECT_GT(at.weight(i), 0) << "a weight, and not a coordinate of another patch";
    }
    EXPECT_EQ(patches, surface.patches.size());
    EXPECT_EQ(at.first_number(), surface.numbers.size());
    EXPECT_EQ(at.first_loop(), surface.segment_counts.size());
    EXPECT_EQ(at.first_segment(), surface.degrees.size());
    EXPECT_EQ(at.first_trim_point(), surface.trim_points.size());
  }
}

}  // namespace
}  // namespace tessera
