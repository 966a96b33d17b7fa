// SPDX-License-Identifier: Apache-2.0
// What rays of a scene version meet, with its spatial index.
// Threads. Built once, then never changed.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/primitive/freeform/patch_store.h"
#include "slave/core/primitive/instancing.h"
#include "slave/core/primitive/primitive_index.h"
#include "slave/core/primitive/triangle/triangle_store.h"

namespace tessera::core {

using MeshList = std::vector<std::shared_ptr<const Mesh>>;

// The part of a scene that lights and materials do not change, but where a surface of patches that
// stands very often begins to shed light, or ends; it is shared by versions of a scene.
struct Geometry {
  TriangleStore triangles;
  std::shared_ptr<const PatchStore> patches;  // null where the scene has none
  // [instance_count + 1] number of the first primitive of each as users count them: triangles and
  // patches. Empty where the scene has no patches; then it is that of `triangles`.
  std::vector<std::uint64_t> first_number;
  std::vector<std::uint64_t> left_out;  // flattened triangles without area, rising
  PrimitiveIndex index;
  std::uint64_t built_primitives = 0;   // put into structures for it
  std::uint64_t fitted_primitives = 0;  // in structures of another version, fitted to this one
  // sah_cost() of the structure when it was built, which fitted ones are compared with; 0: not
  // known.
  double built_cost = 0;
  bool is_smooth = false;  // some mesh has normals that differ from those of its triangles
  // What the geometry was made of. Versions with the same meshes share the list of them, for a copy
  // would count each mesh.
  std::shared_ptr<const MeshList> mesh_list;
  std::vector<std::shared_ptr<const PatchSurface>> surfaces;
  std::vector<bool> is_shareable;  // shareable_surfaces()
  std::vector<Instance> instances;
  Structure structure = Structure::kAuto;
  Instancing instancing = Instancing::kAuto;
  bool is_on_demand = false;

  const MeshList& meshes() const { return *mesh_list; }
};

}  // namespace tessera::core
