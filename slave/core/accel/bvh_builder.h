// SPDX-License-Identifier: Apache-2.0
// Builds a wide bounding volume hierarchy by the surface area heuristic (SAH).
//
// Method. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007: centroids
// are sorted into bins on all axes at once, which makes a binary hierarchy; wide nodes are cut out
// of it so that they cost least (wide_nodes.h). The cost of a leaf is counted by the block, since W
// primitives are tested in the time of one. With a clipper, nodes whose children would overlap are
// split in space (spatial_split.h), all of them or, where that pays (tree_top.h), those near the
// root.
//
// Threads. The calling thread and up to thread_count - 1 more; the result does not depend on their
// number, for the top is cut into tasks by counts alone.
#pragma once

#include "common/base/status.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh.h"
#include "slave/core/accel/bvh_build_config.h"

namespace tessera::core {

// Returns: kCancelled; kResourceExhausted when indices or memory run out.
template <int W>
Result<Bvh<W>> build_bvh(const PrimitiveSet& set, const BuildControl& control,
                         const BvhBuildConfig& config = {});

}  // namespace tessera::core
