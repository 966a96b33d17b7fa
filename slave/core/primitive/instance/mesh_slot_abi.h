// SPDX-License-Identifier: Apache-2.0
// What kernels call where a ray meets a mesh whose structure may not be there yet (mesh_slot.h).
// Fixed-size types and functions that are compiled once, for every instruction set.
//
// A shape that stands for a slot has no nodes, no blocks, and the slot's address in place of its
// triangles', so that the layout of meshes that are built beforehand does not grow.
//
// Threads. Any.
#pragma once

#include "slave/core/primitive/instance_layout.h"

namespace tessera::core {

template <int W>
class MeshSlot;

// Whether met_mesh() has the shape; a mesh without triangles has no instances.
template <int W>
bool is_slot(const MeshShape<W>& mesh) {
  return mesh.nodes == nullptr && mesh.triangles != nullptr;
}

// Returns: the shape of the mesh, built now if no ray has met it before; one without nodes where
// that failed, or where the tile is to be left (MetBuilds). Requires: is_slot(mesh).
const MeshShape<8>& met_mesh(const MeshShape<8>& mesh);
const MeshShape<16>& met_mesh(const MeshShape<16>& mesh);

}  // namespace tessera::core
