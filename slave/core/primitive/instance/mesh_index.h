// SPDX-License-Identifier: Apache-2.0
// The structure of one mesh in its own coordinates, shared by its instances and by versions of a
// scene.
//
// Threads. Built once, then never changed.
#pragma once

#include <memory>
#include <vector>

#include "common/base/status.h"
#include "common/scene/scene.h"
#include "slave/core/primitive/primitive_index.h"

namespace tessera::core {

// The hierarchy holds every triangle whose corners differ: one without area may get some by the
// rounding of its corners in world space, and is judged there.
template <int W>
struct MeshIndex {
  IndexedBvh<W> bvh;
  std::vector<Bounds3f> parts;         // boxes below the root: together they hold all corners
  std::uint64_t degenerate_count = 0;  // of triangles without area, object space

  MeshShape<W> shape() const;
};

// Whether a triangle of these corners is in the hierarchy of its mesh.
inline bool is_in_mesh_index(Vec3f a, Vec3f b, Vec3f c) { return !(a == b || b == c || c == a); }

// The index of a hierarchy that has been built; degenerate_count is left to the caller.
template <int W>
MeshIndex<W> mesh_index_of(IndexedBvh<W> bvh);

// Returns: kCancelled; kResourceExhausted when indices or memory run out.
template <int W>
Result<std::shared_ptr<const MeshIndex<W>>> index_mesh(const Mesh& mesh,
                                                       const BuildControl& control);

}  // namespace tessera::core
