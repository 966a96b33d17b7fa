// SPDX-License-Identifier: Apache-2.0
// A mesh that stands somewhere in the world, as the kernels see it: the structure of the mesh is in
// coordinates of its own ("object space") and shared by all of its instances.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/primitive/triangle/triangle_layout.h"
#include "slave/core/ray/packet_layout.h"

namespace tessera::core {

// Corners are brought to world space by `to_world`, with the operations of Transform::point(), and
// rays are tested against them there. Boxes are tested in object space, where a point x of the
// world is to_object (x - T) with T the last column of to_world.
struct alignas(64) InstanceBlock {
  float to_world[3][4];
  float to_object[3][4];  // by columns, which registers of 4 lanes load; the fourth of each is 0
  // How far a corner in world space, taken back, may be from the mesh's own; by axis, object units.
  float pad[4];
  uint32_t mesh;             // index into TrianglesAndInstances::meshes
  uint32_t first_primitive;  // the number of the mesh's first triangle over the flattened scene
  uint32_t is_identity;      // 1: corners are taken as they are
};
static_assert(sizeof(InstanceBlock) == 128);

// The structure of a mesh in object space.
template <int W>
struct MeshShape {
  const BvhNode<W>* nodes;  // root first; null without triangles
  const TriangleBlock<W>* triangles;
  uint32_t block_count;
  SceneBox box;
};

}  // namespace tessera::core
