// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_footprint.h"

#include <algorithm>

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

bool sheds_light(std::span<const std::byte> mesh, const Scene& root) {
  const auto emits = [](const Material& material) { return material.emission != Vec3f{}; };
  if (std::none_of(root.materials.begin(), root.materials.end(), emits)) return false;
  const std::vector<std::uint32_t> materials = mesh_materials(mesh);
  return std::any_of(materials.begin(), materials.end(), [&](std::uint32_t material) {
    return material < root.materials.size() && emits(root.materials[material]);
  });
}

}  // namespace

bool SceneFootprint::read(const EncodedScene& scene, Scene& root, BlockCounts& counts) {
  if (scene.blocks.empty() || !decode_root(*scene.blocks[0].bytes, root, counts) ||
      !counts.are(scene.blocks.size() - 1)) {
    return false;
  }
  blocks_.resize(scene.blocks.size());
  seen_.for_each_apart(scene.blocks, [&](std::size_t i) {
    const std::span<const std::byte> bytes = *scene.blocks[i].bytes;
    blocks_[i] = {{mesh_triangles(bytes), 0, 0, 0}, surface_counts(bytes), 0};
    if (is_picture(bytes)) blocks_[i].picture_bytes = bytes.size();
  });
  seen_ = BlockTable::Trace(scene.blocks);
  return true;
}

PrimitiveCounts SceneFootprint::counts_of(const EncodedScene& scene) {
  Scene root;
  BlockCounts counts;
  if (!read(scene, root, counts)) return {};
  return counts_of(root, counts);
}

PrimitiveCounts SceneFootprint::counts_of(const Scene& root, const BlockCounts& counts) const {
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

// Of all meshes, where they stand.
std::uint64_t SceneFootprint::mesh_bytes(const EncodedScene& scene, const Scene& root,
                                         const BlockCounts& counts) const {
  std::vector<std::uint64_t> copies(counts.meshes, 0);
  for (const Instance& instance : root.instances) {
    if (instance.kind == ObjectKind::kMesh && instance.mesh < counts.meshes)
      ++copies[instance.mesh];
  }
  std::uint64_t bytes = 0;
  for (std::size_t m = 0; m < copies.size(); ++m) {
    const std::uint64_t triangles = blocks_[1 + m].mesh.triangles;
    const bool is_shared = copies[m] > 1 && (copies[m] - 1) * triangles >= kSharedTrianglesMin &&
                           !sheds_light(*scene.blocks[1 + m].bytes, root);
    bytes += is_shared ? kIndexBytesPerTriangle * triangles + kIndexBytesPerInstance * copies[m]
                       : kIndexBytesPerTriangle * triangles * copies[m];
  }
  return bytes;
}

std::uint64_t SceneFootprint::index_bytes_of(const EncodedScene& scene,
                                             const SurfaceBytes& surface_bytes) {
  Scene root;
  BlockCounts block_counts;
  if (!read(scene, root, block_counts)) return 0;
  const PrimitiveCounts counts = counts_of(root, block_counts);
  if (counts.triangles == 0 && counts.patches == 0) return 0;
  std::uint64_t picture_bytes = 0;
  for (const Content& block : blocks_) picture_bytes += block.picture_bytes;
  std::uint64_t bytes = mesh_bytes(scene, root, block_counts) + picture_bytes / 3 * 4;
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
