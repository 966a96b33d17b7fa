// SPDX-License-Identifier: Apache-2.0
// Memory layout of a kd-tree node, shared by the builder (scalar) and the kernels (SIMD).
// Fixed-size types only and no functions: kernel files are compiled once per instruction set, and
// an inline function compiled twice with different flags breaks the one-definition rule.
//
// Layout after Wald, "Realtime Ray Tracing and Interactive Global Illumination", PhD thesis,
// Saarland University, 2004: 8 bytes, so that 8 nodes share a 64-byte cache line and the two
// children of a node lie side by side.
//
//   inner node:  bits 0-1  = split axis (0 = x, 1 = y, 2 = z)
//                bits 2-31 = index of the lower child; the upper child is the next node
//                split     = position of the plane on that axis, world units
//   leaf:        bits 0-1  = 3
//                bits 2-31 = index of the first entry in KdTree::primitive_refs()
//                count     = number of entries, 0 for an empty voxel
#pragma once

#include <stdint.h>

namespace tessera::core {

inline constexpr uint32_t kKdLeafTag = 3;
inline constexpr uint32_t kKdIndexMax = (1u << 30) - 1;

struct KdNode {
  uint32_t tag_and_index;
  union {
    float split;
    uint32_t count;
  };
};

static_assert(sizeof(KdNode) == 8, "8 nodes per cache line; traversal relies on it");

// Deepest leaf a builder may make (the root has depth 0). The traversal stack of every kernel has
// this many entries: a step down pushes at most one, so the kernel needs no check in its loop. The
// usual rule 8 + 1.3 log2(n) (Havran and Bittner, "On improving kd-trees for ray shooting", 2002)
// gives 47 for the 2^30 entries that a node can address; 56 leaves room.
inline constexpr int kKdDepthMax = 56;

}  // namespace tessera::core
