// SPDX-License-Identifier: Apache-2.0
#include "common/scene/scene_footprint.h"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "common/math/transform_checks.h"
#include "common/scene/block_bytes.h"
#include "common/scene/mesh_block.h"
#include "common/scene/root_block.h"

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

// The materials of a surface's patches, and whether it has lists of trims. Returns: no materials
// where they cannot be read.
std::vector<std::uint32_t> surface_materials(std::span<const std::byte> bytes, bool& is_trimmed) {
  BlockReader in(bytes);
  std::vector<std::uint32_t> materials;
  const bool is_good = in.open(BlockKind::kPatchSurface) && in.skip_array(sizeof(PatchForm)) &&
                       in.skip_array(sizeof(float)) && in.get_array(materials);
  if (!is_good) return {};
  is_trimmed = in.get_count(sizeof(std::uint32_t)) > 0;
  return materials;
}

// Whether lists of materials have one that sheds light. Each list is looked through once.
class Lamps {
 public:
  explicit Lamps(const std::vector<Material>& materials) : materials_(materials) {}

  bool are_in(const std::vector<std::uint32_t>& list) {
    const auto [at, is_new] = known_.try_emplace(&list, false);
    if (is_new) {
      at->second = std::any_of(list.begin(), list.end(), [&](std::uint32_t material) {
        return material < materials_.size() && materials_[material].emission != Vec3f{};
      });
    }
    return at->second;
  }

 private:
  const std::vector<Material>& materials_;
  std::unordered_map<const void*, bool> known_;
};

// Returns: nothing to speak of for a block that cannot be read.
SurfaceReach surface_reach(std::span<const std::byte> bytes) {
  BlockReader in(bytes);
  std::vector<PatchForm> forms;
  std::vector<float> numbers;
  if (!in.open(BlockKind::kPatchSurface) || !in.get_array(forms) || !in.get_array(numbers))
    return {};
  return reach_of(forms, numbers);
}

std::shared_ptr<const std::vector<std::uint32_t>> distinct(
    const std::vector<std::uint32_t>& materials) {
  std::unordered_set<std::uint32_t> all;
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (i == 0 || materials[i] != materials[i - 1]) all.insert(materials[i]);
  return std::make_shared<const std::vector<std::uint32_t>>(all.begin(), all.end());
}

}  // namespace

bool SceneFootprint::read(const EncodedScene& scene, Scene& root, BlockCounts& counts) {
  if (scene.blocks.empty() || !decode_root(*scene.blocks[0].bytes, root, counts) ||
      !counts.are(scene.blocks.size() - 1)) {
    return false;
  }
  blocks_.resize(scene.blocks.size());
  // Where memory ends between here and the end, nothing is taken for seen.
  const BlockTable::Trace seen = std::exchange(seen_, {});
  std::unordered_map<Digest, std::size_t, DigestHash> read;  // a block may be there very often
  seen.for_each_apart(scene.blocks, [&](std::size_t i) {
    const auto [known, is_new] = read.try_emplace(scene.blocks[i].digest, i);
    if (!is_new) {
      blocks_[i] = blocks_[known->second];
      return;
    }
    const std::span<const std::byte> bytes = *scene.blocks[i].bytes;
    Content content{{mesh_triangles(bytes), 0, 0, 0}, surface_counts(bytes), 0, nullptr, false, {}};
    if (content.mesh.triangles > 0) content.materials = distinct(mesh_materials(bytes));
    if (content.surface.patches > 0)
      content.materials = distinct(surface_materials(bytes, content.is_trimmed));
    if (is_picture(bytes)) content.picture_bytes = bytes.size();
    blocks_[i] = std::move(content);
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
std::uint64_t SceneFootprint::mesh_bytes(const Scene& root, const BlockCounts& counts,
                                         bool has_patches) const {
  struct Places {
    std::uint64_t all = 0, flat = 0;  // flat: whose matrix has no inverse
  };
  std::vector<Places> places(counts.meshes);
  for (const Instance& instance : root.instances) {
    if (instance.kind != ObjectKind::kMesh || instance.mesh >= counts.meshes) continue;
    ++places[instance.mesh].all;
    places[instance.mesh].flat += is_singular(instance.object_to_world) ? 1 : 0;
  }
  Lamps lamps(root.materials);
  std::uint64_t bytes = 0;
  for (std::size_t m = 0; m < places.size(); ++m) {
    const Content& block = blocks_[1 + m];
    const std::uint64_t of_mesh = kIndexBytesPerTriangle * block.mesh.triangles;
    const auto [all, flat] = places[m];
    const bool is_shared = !has_patches && all > 1 &&
                           (all - 1) * block.mesh.triangles >= kSharedTrianglesMin &&
                           !lamps.are_in(*block.materials);
    bytes += is_shared ? of_mesh * (1 + flat) + kIndexBytesPerInstance * all : of_mesh * all;
  }
  return bytes;
}

// By surface of the scene.
std::vector<SceneFootprint::SurfacePlaces> SceneFootprint::surface_places(
    const EncodedScene& scene, const Scene& root, const BlockCounts& counts) {
  std::vector<SurfacePlaces> places(counts.surfaces);
  const auto stands_in = [&](const Instance& instance) {
    return instance.kind == ObjectKind::kPatchSurface && instance.mesh < counts.surfaces;
  };
  for (const Instance& instance : root.instances)
    if (stands_in(instance)) ++places[instance.mesh].all;
  Lamps lamps(root.materials);
  const bool is_still = !scene.is_animated();  // else places may come to where none can share
  for (std::size_t s = 0; s < places.size(); ++s) {
    const std::size_t number = 1 + counts.meshes + s;
    Content& block = blocks_[number];
    places[s].is_shared = is_still && places[s].all > 1 && !block.is_trimmed &&
                          (places[s].all - 1) * block.surface.patches >= kSharedPatchesMin &&
                          !lamps.are_in(*block.materials);
    if (places[s].is_shared && !block.reach)
      block.reach = surface_reach(*scene.blocks[number].bytes);
  }
  for (const Instance& instance : root.instances) {
    if (!stands_in(instance) || !places[instance.mesh].is_shared) continue;
    const SurfaceReach& reach = *blocks_[1 + counts.meshes + instance.mesh].reach;
    if (!may_share(reach, instance.object_to_world)) ++places[instance.mesh].flattened;
  }
  return places;
}

// Of all surfaces, where they stand.
std::uint64_t SceneFootprint::patch_bytes(const EncodedScene& scene, const Scene& root,
                                          const BlockCounts& counts, std::uint64_t patches,
                                          const SurfaceBytes& surface_bytes) {
  constexpr std::uint64_t kPerBitOfPart = 4000;  // a part takes some 500 bytes
  const std::vector<SurfacePlaces> places = surface_places(scene, root, counts);
  std::uint64_t bytes = kIndexBytesOfThreads;
  bool is_any_shared = false;
  for (std::size_t s = 0; s < places.size(); ++s) {
    const std::size_t number = 1 + counts.meshes + s;
    const PrimitiveCounts& of = blocks_[number].surface;
    const SurfacePlaces& at = places[s];
    if (at.all == 0) continue;
    const auto of_copies = [&](std::uint64_t copies) {
      return surface_bytes
                 ? surface_bytes(scene.blocks[number], copies, patches)
                 : copies * (kIndexBytesPerPatch * of.patches + 2 * sizeof(float) * of.numbers +
                             kIndexBytesPerTrimPoint * of.trim_points);
    };
    bytes += of_copies(at.is_shared ? 1 + at.flattened : at.all);
    if (at.is_shared) bytes += at.all * (kIndexBytesPerInstance + of_copies(1) / kPerBitOfPart);
    is_any_shared = is_any_shared || at.is_shared;
  }
  return bytes + (is_any_shared ? kPlacedPartsThreads * kPlacedPartsBytes : 0);
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
  std::uint64_t bytes = mesh_bytes(root, block_counts, counts.patches > 0) + picture_bytes / 3 * 4;
  if (counts.patches > 0)
    bytes += patch_bytes(scene, root, block_counts, counts.patches, surface_bytes);
  return bytes;
}

PrimitiveCounts primitive_counts_of(const EncodedScene& scene) {
  return SceneFootprint().counts_of(scene);
}

std::uint64_t index_bytes_of(const EncodedScene& scene, const SurfaceBytes& surface_bytes) {
  return SceneFootprint().index_bytes_of(scene, surface_bytes);
}

}  // namespace tessera
