// SPDX-License-Identifier: Apache-2.0
// Builds a wide bounding volume hierarchy by the surface area heuristic (SAH).
//
// Method. Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007: centroids
// are sorted into bins on all axes at once; a node splits its largest child until it is full.
// The cost of a leaf is counted by the block, since W primitives are tested in the time of one.
// With a clipper, nodes whose children would overlap are split in space (spatial_split.h).
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
  // Not null: primitives are cut where that is cheaper. References that cuts add are at most this
  // share of all primitives, which bounds memory; a range hands its share down to its halves by
  // their sizes, so that the hierarchy does not depend on the order of building.
  const PrimitiveClipper* clipper = nullptr;
  float cuts_max = 0.5f;
  // A split in space is tried where the halves by centroids share a box of more than this part of
  // the whole scene's area. It is taken where its cost, times cut_weight, is below theirs.
  float overlap_min = 1e-5f;
  float cut_weight = 1.0f;
  // Splits are chosen by numbers of primitives, and not of blocks: for cuts, which would seldom pay
  // where a part more is a block more.
  bool counts_primitives = false;
};

// The hierarchy of quality. Requires: the clipper outlives the build.
BvhBuildConfig spatial_build(const PrimitiveClipper& clipper);

// Returns: kCancelled; kResourceExhausted when indices or memory run out.
template <int W>
Result<Bvh<W>> build_bvh(const PrimitiveSet& set, const BuildControl& control,
                         const BvhBuildConfig& config = {});

}  // namespace tessera::core
