// SPDX-License-Identifier: Apache-2.0
// What moves the vertices of a glTF primitive: the joints and weights of a skin, and morph targets
// (glTF 2.0, sections 3.7.2.2 and 3.7.3.3).
// Threads. One.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/scene/animation.h"
#include "master/import/gltf/accessor.h"
#include "master/import/gltf/document.h"

namespace tessera::import {

struct GltfDeformation {
  std::uint32_t influence_count = 0;  // for each vertex; 0: the primitive names no joints
  std::uint32_t joint_count = 0;      // 1 above the greatest joint
  std::vector<Influence> influences;  // [vertex][influence_count]
  std::uint32_t target_count = 0;
  bool has_normals = false, has_tangents = false;
  std::vector<Vec3f> deltas;  // SceneAnimation::deltas, of this mesh
  bool is_any() const { return influence_count > 0 || target_count > 0; }
};

// The vertices of a primitive that its mesh has.
struct GltfVertices {
  // Finds an attribute of `low` to `high` components. Returns: nothing when it is absent.
  std::function<Result<std::optional<GltfAccessor>>(const std::string& name, std::size_t low,
                                                    std::size_t high)>
      find;
  std::function<std::size_t(std::size_t vertex)> source_of;  // where it is in the accessors
  std::size_t count = 0;
  std::size_t source_count = 0;  // elements that an accessor has at least
};

// Returns: an error that names primitive, target and vertex.
Result<GltfDeformation> read_deformation(GltfDocument& document, const GltfObject& primitive,
                                         const GltfVertices& vertices);

}  // namespace tessera::import
