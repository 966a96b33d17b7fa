// An immutable bounding volume hierarchy over triangles, W children and W triangles wide.
//
// Threads. Built by build_bvh(), then never changed.
//
// Invariants, checked by validate():
//   (1) Every node but the root has one parent, in front of it; none is deeper than kBvhDepthMax.
//   (2) A child's box holds the boxes of all that lies below it.
//   (3) Every triangle with a box that is not empty stands in exactly one block; primitives ascend
//       within a leaf.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/status.h"
#include "common/math/bounds3.h"
#include "slave/core/accel/bvh_layout.h"

namespace tessera::core {

template <int W>
struct Bvh {
  Bounds3f bounds;                // empty without triangles
  std::vector<BvhNode<W>> nodes;  // root first; empty without triangles
  std::vector<TriangleBlock<W>> blocks;

  std::uint64_t memory_bytes() const {
    return nodes.capacity() * sizeof(BvhNode<W>) + blocks.capacity() * sizeof(TriangleBlock<W>);
  }
  // Walks everything. Shape: boxes [triangle_count]. Returns: kInternal naming what is broken.
  Status validate(std::span<const Bounds3f> boxes) const;
};

}  // namespace tessera::core
