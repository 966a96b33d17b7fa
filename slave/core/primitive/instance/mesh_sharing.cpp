// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/mesh_sharing.h"

#include <algorithm>
#include <cstring>
#include <unordered_set>
#include <utility>

#include "common/scene/scene_footprint.h"

namespace tessera::core {
namespace {

using MeshSet = std::unordered_set<const Mesh*>;

MeshSet set_of(std::span<const std::shared_ptr<const Mesh>> meshes) {
  MeshSet set;
  for (const auto& mesh : meshes) set.insert(mesh.get());
  return set;
}

bool is_lamp(const Mesh& mesh, const Scene& scene) {
  return std::any_of(mesh.materials.begin(), mesh.materials.end(), [&](std::uint32_t material) {
    return scene.materials[material].emission != Vec3f{};
  });
}

}  // namespace

SceneChange change_of(const Scene& scene, std::span<const std::shared_ptr<const Mesh>> meshes,
                      std::span<const Instance> instances) {
  SceneChange change;
  change.has_same_meshes =
      std::equal(scene.meshes.begin(), scene.meshes.end(), meshes.begin(), meshes.end());
  if (!change.has_same_meshes || scene.instances.size() != instances.size()) return change;
  std::vector<std::uint32_t> moved;
  for (std::uint32_t i = 0; i < instances.size(); ++i) {
    const Instance &now = scene.instances[i], &then = instances[i];
    if (std::memcmp(&now, &then, sizeof now) == 0) continue;  // all but a few, at most
    if (now.mesh != then.mesh || now.kind != then.kind) return change;
    if (now.object_to_world != then.object_to_world) moved.push_back(i);
  }
  change.moved = std::move(moved);
  return change;
}

bool keeps_most_of(const Scene& scene, const KnownScene& known) {
  if (known.change.has_same_meshes) {
    return std::any_of(scene.meshes.begin(), scene.meshes.end(),
                       [](const auto& mesh) { return !mesh->triangles.empty(); });
  }
  MeshSet others;  // made where a mesh is not at the place that it had
  std::uint64_t kept = 0, fresh = 0;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const auto& mesh = scene.meshes[m];
    bool is_kept = m < known.meshes.size() && known.meshes[m] == mesh;
    if (!is_kept) {
      if (others.empty()) others = set_of(known.meshes);
      is_kept = others.contains(mesh.get());
    }
    (is_kept ? kept : fresh) += mesh->triangles.size();
  }
  return kept > 0 && kept >= fresh;
}

std::vector<bool> moving_meshes(const Scene& scene, const KnownScene& known) {
  std::vector<bool> is_moving(scene.meshes.size(), false);
  if (!keeps_most_of(scene, known)) return is_moving;
  if (known.change.has_same_meshes) {
    if (!known.is_moving.empty()) is_moving = known.is_moving;
  } else {
    MeshSet moved;
    for (std::size_t m = 0; m < known.is_moving.size(); ++m) {
      if (known.is_moving[m]) moved.insert(known.meshes[m].get());
    }
    for (std::size_t m = 0; m < scene.meshes.size(); ++m)
      is_moving[m] = moved.contains(scene.meshes[m].get());
  }
  if (known.change.moved) {
    for (const std::uint32_t i : *known.change.moved) is_moving[scene.instances[i].mesh] = true;
    return is_moving;
  }
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Instance* const other = i < known.instances.size() ? &known.instances[i] : nullptr;
    const bool is_same = other != nullptr &&
                         known.meshes[other->mesh] == scene.meshes[instance.mesh] &&
                         other->object_to_world == instance.object_to_world;
    if (!is_same) is_moving[instance.mesh] = true;
  }
  return is_moving;
}

std::vector<bool> shared_meshes(const Scene& scene, Instancing instancing,
                                const std::vector<bool>& is_moving) {
  std::vector<bool> is_shared(scene.meshes.size(), false);
  if (instancing == Instancing::kNever) return is_shared;
  std::vector<std::uint64_t> count(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++count[instance.mesh];
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    // Of thousands of meshes that stand once, none is looked at.
    if (count[m] == 0 || (count[m] == 1 && !is_moving[m] && instancing != Instancing::kAlways))
      continue;
    const std::uint64_t triangles = scene.meshes[m]->triangles.size();
    if (triangles == 0) continue;
    const bool pays = (count[m] - 1) * triangles >= kSharedTrianglesMin || is_moving[m];
    if (!pays && instancing != Instancing::kAlways) continue;
    is_shared[m] = !is_lamp(*scene.meshes[m], scene);
  }
  return is_shared;
}

std::uint64_t bytes_without_sharing(const Scene& scene) {
  const std::vector<bool> is_shared =
      shared_meshes(scene, Instancing::kAuto, std::vector<bool>(scene.meshes.size(), false));
  if (std::find(is_shared.begin(), is_shared.end(), true) == is_shared.end()) return 0;
  return kIndexBytesPerTriangle * scene.triangle_count();
}

}  // namespace tessera::core
