// SPDX-License-Identifier: Apache-2.0
// Which meshes of a scene get a structure of their own: those of which many copies stand, for their
// memory, and those that move, so that a version of the scene in which one stands elsewhere does
// not build what all the others are.
//
// Threads. Plain functions.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/primitive/instancing.h"

namespace tessera::core {

// What a scene has in common with another version of it.
struct SceneChange {
  bool has_same_meshes = false;  // each at the number that it had
  // Where only places of instances differ: those that stand elsewhere, rising. Nothing where more
  // than that differs.
  std::optional<std::vector<std::uint32_t>> moved;
};

SceneChange change_of(const Scene& scene, std::span<const std::shared_ptr<const Mesh>> meshes,
                      std::span<const Instance> instances);

// What another version of the scene was made of.
struct KnownScene {
  std::span<const std::shared_ptr<const Mesh>> meshes;  // empty: there is no other version
  std::span<const Instance> instances;
  std::vector<bool> is_moving;  // by mesh, as moving_meshes() found; may be empty
  SceneChange change = {};      // to the scene at hand
};

// Returns: whether half of the triangles are of meshes that the other version has, so that it pays
// to keep what was built for it. Triangles of a mesh count once.
bool keeps_most_of(const Scene& scene, const KnownScene& known);

// Returns: for each mesh, whether it moves: an instance of it is another one in the other version,
// or that version knew it as moving. None moves where most triangles are of meshes that the other
// version does not have: little would be kept, and rays are slower in two levels.
std::vector<bool> moving_meshes(const Scene& scene, const KnownScene& known);

// Shape: is_moving [mesh_count]. Meshes with surfaces that shed light share nothing: each of their
// triangles is a lamp of its own. Returns: for each mesh, whether it gets a structure of its own.
std::vector<bool> shared_meshes(const Scene& scene, Instancing instancing,
                                const std::vector<bool>& is_moving);

// Returns: the bytes of the index, as index_bytes_of() reckons them (scene_footprint.h), where
// nothing is shared though some mesh would be for its memory; 0 where there is none.
std::uint64_t bytes_without_sharing(const Scene& scene);

}  // namespace tessera::core
