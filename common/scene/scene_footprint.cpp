// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_footprint.h"

#include "common/scene/block_bytes.h"
#include "common/scene/mesh_block.h"
#include "common/scene/root_block.h"
#include "common/scene/surface_copies.h"

namespace tessera {
namespace {

PrimitiveCounts surface_counts(std::span<const std::byte> bytes) {
  BlockReader in(bytes);
  PrimitiveCounts counts;
  const auto skip = [&](std::uint64_t bytes_each, std::uint64_t& count) {
    BlockReader ahead = in;
    count = ahead.get_count(bytes_each);
    return in.skip_array(bytes_each);
  };
  std::uint64_t passed = 0;
  const bool is_good =
      in.open(BlockKind::kPatchSurface) && skip(sizeof(PatchForm), counts.patches) &&
      skip(sizeof(float), counts.numbers) && skip(sizeof(std::uint32_t), passed) &&
      skip(sizeof(std::uint32_t), passed) && skip(sizeof(std::uint32_t), passed) &&
      skip(sizeof(std::uint8_t), passed) && skip(sizeof(TrimPoint), counts.trim_points);
  return is_good ? counts : PrimitiveCounts{};
}

bool is_picture(std::span<const std::byte> bytes) {
  return BlockReader(bytes).open(BlockKind::kTexture) ||
         BlockReader(bytes).open(BlockKind::kEnvironment);
}

}  // namespace

void SceneFootprint::read(const EncodedScene& scene) {
  blocks_.resize(scene.blocks.size());
  seen_.for_each_apart(scene.blocks, [&](std::size_t i) {
    const std::span<const std::byte> bytes = *scene.blocks[i].bytes;
    blocks_[i] = {{mesh_triangles(bytes), 0, 0, 0}, surface_counts(bytes), 0};
    if (is_picture(bytes)) blocks_[i].picture_bytes = bytes.size();
  });
  seen_ = BlockTable::Trace(scene.blocks);
}

PrimitiveCounts SceneFootprint::counts_of(const EncodedScene& scene) {
  Scene root;
  BlockCounts counts;
  if (scene.blocks.empty() || !decode_root(*scene.blocks[0].bytes, root, counts) ||
      !counts.are(scene.blocks.size() - 1)) {
    return {};
  }
  read(scene);
  PrimitiveCounts total;
  for (const Instance& instance : root.instances) {
    const bool is_mesh = instance.kind == ObjectKind::kMesh;
    if (instance.mesh >= (is_mesh ? counts.meshes : counts.surfaces)) continue;
    const Content& block = blocks_[1 + instance.mesh + (is_mesh ? 0 : counts.meshes)];
    const PrimitiveCounts& object = is_mesh ? block.mesh : block.surface;
    total.triangles += object.triangles;
    total.patches += object.patches;
    total.numbers += object.numbers;
    total.trim_points += object.trim_points;
  }
  return total;
}

std::uint64_t SceneFootprint::index_bytes_of(const EncodedScene& scene,
                                             const SurfaceBytes& surface_bytes) {
  const PrimitiveCounts counts = counts_of(scene);
  if (counts.triangles == 0 && counts.patches == 0) return 0;
  std::uint64_t picture_bytes = 0;
  for (const Content& block : blocks_) picture_bytes += block.picture_bytes;
  std::uint64_t bytes = kIndexBytesPerTriangle * counts.triangles + picture_bytes / 3 * 4;
  if (counts.patches > 0) bytes += kIndexBytesOfThreads;
  if (surface_bytes && counts.patches > 0) {
    for (const SurfaceCopies& surface : surface_copies_of(scene))
      bytes += surface_bytes(scene.blocks[surface.block], surface.copies, counts.patches);
  } else {
    bytes += kIndexBytesPerPatch * counts.patches + 2 * sizeof(float) * counts.numbers +
             kIndexBytesPerTrimPoint * counts.trim_points;
  }
  return bytes;
}

PrimitiveCounts primitive_counts_of(const EncodedScene& scene) {
  return SceneFootprint().counts_of(scene);
}

std::uint64_t index_bytes_of(const EncodedScene& scene, const SurfaceBytes& surface_bytes) {
  return SceneFootprint().index_bytes_of(scene, surface_bytes);
}

}  // namespace tessera
