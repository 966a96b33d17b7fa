// SPDX-License-Identifier: Apache-2.0
// What is flattened of a scene with instances. In a version of a scene that follows another it has
// a structure of its own, in world space, and stands in the hierarchy over the instances as one
// more of them, whose transform is the identity: so it is not built again while it stays as it is.
//
// Threads. Built once, then never changed.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/primitive/instance/mesh_index.h"

namespace tessera::core {

// An instance that is flattened.
struct FlatInstance {
  std::shared_ptr<const Mesh> mesh;
  Transform to_world;
  std::uint64_t first = 0;  // the number of its first triangle over the flattened scene

  bool operator==(const FlatInstance&) const = default;
};

template <int W>
struct FlatPart {
  std::vector<FlatInstance> made_of;
  std::shared_ptr<const MeshIndex<W>> index;  // null: its triangles are in the common hierarchy

  // Numbers of its triangles over the flattened scene, in order.
  std::vector<std::uint32_t> numbers() const;
};

// Shape: is_placed [instance_count], 1 where an instance is not flattened.
template <int W>
FlatPart<W> flat_part_of(const Scene& scene, std::span<const std::uint8_t> is_placed);

// Builds its structure. Shape: boxes [triangle], vertices [triangle][3][3], both of this part.
template <int W>
Status index_flat_part(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                       const BuildControl& control, FlatPart<W>& part);

}  // namespace tessera::core
