// SPDX-License-Identifier: Apache-2.0
// An immutable bounding volume hierarchy over primitives, W children wide.
//
// Threads. Built by build_bvh(), then never changed.
//
// Invariants, checked by validate():
//   (1) Every node but the root has one parent, in front of it; none is deeper than kBvhDepthMax.
//   (2) A child's box holds the boxes of all that lies below it.
//   (3) Every primitive with a box that is not empty stands in exactly one block; primitives
//       ascend by number within a leaf. Where primitives were cut, one stands in a leaf for each of
//       its parts, and (2) holds for the parts.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/status.h"
#include "common/base/uninitialized_allocator.h"
#include "common/math/bounds3.h"
#include "slave/core/accel/bvh_layout.h"
#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

template <int W>
using BvhNodes = std::vector<BvhNode<W>, UninitializedAllocator<BvhNode<W>>>;

template <int W>
struct Bvh {
  Bounds3f bounds;    // empty without primitives
  BvhNodes<W> nodes;  // root first; empty without primitives

  std::uint64_t memory_bytes() const { return nodes.capacity() * sizeof(BvhNode<W>); }
  // Walks the whole hierarchy. Requires: it was built from this set. `clipper`: the one that cut
  // its primitives; null where they are whole. Returns: kInternal naming what is broken.
  Status validate(const PrimitiveSet& set, const PrimitiveClipper* clipper = nullptr) const;
};

}  // namespace tessera::core
