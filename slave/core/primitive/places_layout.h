// SPDX-License-Identifier: Apache-2.0
// Scenes of patches some of whose surfaces are shared by their places, as kernels see them; beside
// the sets of primitives of shapes_layout.h.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/accel/bvh_layout.h"
#include "slave/core/primitive/shapes_layout.h"

namespace tessera::core {

// A surface of patches that several places share, in its own coordinates ("object space").
template <int W>
struct SurfaceShape {
  const BvhNode<W>* nodes;  // root first
  const uint32_t* blocks;   // [number of a block]: that of a sub-patch, with kIsItem
  const SubPatch* parts;    // their `patch` and `primitive` are numbers within the surface
  const Patch* patches;
  uint32_t part_count;
  SceneBox box;
};

// Items below part_count are sub-patches in world space, those from there on are places.
template <int W>
struct TrianglesAndPlaces {
  const uint32_t* blocks;
  const TriangleBlock<W>* triangles;
  const SubPatch* parts;
  const Patch* patches;
  uint32_t part_count;
  uint64_t first_place;         // number of the first place among those of all scenes
  const InstanceBlock* places;  // `mesh` is the number of a surface
  const SurfaceShape<W>* surfaces;
};

}  // namespace tessera::core
