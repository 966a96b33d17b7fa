// SPDX-License-Identifier: Apache-2.0
// Scenes with instances in two levels: each mesh that stands more than once gets one hierarchy,
// which its instances share; a hierarchy over the instances, and over the triangles that are
// flattened, stands above.
//
// After Wald, Benthin, Slusallek, "Distributed interactive ray tracing of dynamic scenes", 2003,
// and section 7 of Benthin's thesis, but for one thing: triangles are tested in world space.
//
// Threads. Built by the calling thread and up to thread_count - 1 more.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/base/status.h"
#include "common/scene/scene.h"
#include "slave/core/primitive/instance/flat_part.h"
#include "slave/core/primitive/instance/mesh_index.h"
#include "slave/core/primitive/instance/mesh_sharing.h"
#include "slave/core/primitive/instance/mesh_slot.h"
#include "slave/core/primitive/instancing.h"
#include "slave/core/primitive/primitive_index.h"

namespace tessera::core {

// The instances of a scene that are not flattened.
template <int W>
struct Placement {
  std::vector<std::shared_ptr<const MeshIndex<W>>> meshes;  // [mesh_count], null: flattened
  // [mesh_count], not null: takes the place of the mesh above, and is built when a ray meets it
  std::vector<std::shared_ptr<MeshSlot<W>>> slots;
  std::vector<bool> is_moving;           // [mesh_count]
  std::vector<std::uint8_t> is_placed;   // [instance_count]
  std::vector<InstanceBlock> instances;  // the placed ones, in order
  std::vector<Bounds3f> boxes;           // of the placed ones, world space
  std::uint64_t degenerate_count = 0;    // triangles of the placed ones
  std::uint64_t built_primitives = 0;    // triangles of meshes built for it

  bool is_empty() const { return instances.empty(); }
};

// What another version of the scene has; instances and meshes that are the same are taken from
// there and not built.
template <int W>
struct KnownInstances {
  KnownScene scene;
  const InstancedBvh<W>* index = nullptr;  // null: all of it is flattened, or there is none
  std::span<const std::uint64_t> first_numbers = {};  // [instance_count + 1], of triangles
};

// Which meshes get a structure of their own, and when.
struct PlacementOptions {
  Instancing instancing = Instancing::kAuto;
  bool is_on_demand = false;  // every mesh that can get one gets it when the first ray meets it
};

// Returns: kCancelled; kResourceExhausted.
template <int W>
Result<Placement<W>> place_instances(const Scene& scene, const PlacementOptions& options,
                                     const KnownInstances<W>& known, const BuildControl& control);

// Returns: whether the same instances are flattened as in the other version, and all stand where
// they stood.
template <int W>
bool has_same_flat_part(const Placement<W>& placement, const KnownInstances<W>& known);

// What is flattened beside the instances. Shape: boxes [triangle], vertices [triangle][3][3];
// unused where the part has a structure of its own.
template <int W>
struct Flattened {
  std::shared_ptr<const FlatPart<W>> part;  // null: nothing is flattened
  std::span<const Bounds3f> boxes;
  std::span<const float> vertices;
};

// The hierarchy over the instances of another version is taken where few of them have moved since
// it was built; those are moved in it. Returns: kCancelled; kResourceExhausted.
template <int W>
Result<InstancedBvh<W>> index_instances(Placement<W> placement, Flattened<W> flattened,
                                        const InstancedBvh<W>* known, const BuildControl& control);

}  // namespace tessera::core
