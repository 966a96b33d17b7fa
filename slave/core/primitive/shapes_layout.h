// SPDX-License-Identifier: Apache-2.0
// The blocks of primitives that the leaves of a structure name, as the kernels see them: a type for
// each set of kinds that scenes have. Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/primitive/instance_layout.h"
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/primitive/triangle/triangle_layout.h"

namespace tessera::core {

inline constexpr uint32_t kNoBlock = 0xffffffffu;

// Scenes of triangles alone: the number of a block is that of a triangle block.
template <int W>
struct TrianglesOnly {
  const TriangleBlock<W>* triangles;
};

// Scenes with another kind of primitive: blocks[number of a block] is the number of a triangle
// block, or, with this bit, of an item of the other kind.
inline constexpr uint32_t kIsItem = 0x80000000u;

// Scenes with instances.
template <int W>
struct TrianglesAndInstances {
  const uint32_t* blocks;
  const TriangleBlock<W>* triangles;  // world space
  const InstanceBlock* instances;     // the items
  const MeshShape<W>* meshes;
};

// Scenes with patches; all is in world space.
template <int W>
struct TrianglesAndPatches {
  const uint32_t* blocks;
  const TriangleBlock<W>* triangles;
  const SubPatch* parts;  // the items
  const Patch* patches;
};

}  // namespace tessera::core
