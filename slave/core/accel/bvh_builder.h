// SPDX-License-Identifier: Apache-2.0
// Builds a wide bounding volume hierarchy by the surface area heuristic (SAH).
//
// Method. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007: centroids
// are sorted into bins on all axes at once; a node splits its largest child until it is full.
// The cost of a leaf is counted by the block, since W primitives are tested in the time of one.
//
// Threads. The calling thread and up to thread_count - 1 more; the result does not depend on their
// number, for the top is cut into tasks by counts alone.
#pragma once

#include "common/base/status.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh.h"

namespace tessera::core {

struct BvhBuildConfig {
  float cost_node = 1.0f;   // testing the boxes of a node, the unit
  float cost_block = 1.0f;  // testing a block of primitives
};

// Returns: kCancelled; kResourceExhausted when indices or memory run out.
template <int W>
Result<Bvh<W>> build_bvh(const PrimitiveSet& set, const BuildControl& control,
                         const BvhBuildConfig& config = {});

}  // namespace tessera::core
