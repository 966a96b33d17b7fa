// SPDX-License-Identifier: Apache-2.0
// How a wide bounding volume hierarchy is to be built, beside the number of threads.
//
// Threads. Plain values.
#pragma once

#include <cstdint>

#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

struct BvhBuildConfig {
  float cost_node = 1.5f;   // testing the boxes of a wide node
  float cost_block = 1.0f;  // testing a block of primitives, the unit
  // Not null: primitives are cut where that is cheaper. References that cuts add are at most this
  // share of all primitives, which bounds memory; a range hands its share down to its halves by
  // their sizes, so that the hierarchy does not depend on the order of building.
  const PrimitiveClipper* clipper = nullptr;
  float cuts_max = 0.1f;
  // A split in space is tried where the halves by centroids share a box of more than these parts of
  // the area of the whole scene, and of the range. It is taken where its cost, times cut_weight, is
  // below theirs: splits below may still part what overlaps here, and parts are more than wholes.
  float overlap_min = 1e-3f;
  float overlap_share = 0.2f;
  float cut_weight = 1.2f;
  // Cuts are made near the root alone, in ranges that are too large to be one task's.
  bool only_top_is_cut = false;
  // Cuts are made only if what lies below those near the root is then cheaper than without them.
  bool cuts_have_to_pay = false;
  // Ranges are split until a block holds so many of them: parts of a block may then be children of
  // wide nodes by themselves where that is cheaper.
  std::uint32_t leaves_per_block = 1;
  // So many times each subtree is tried at all other places (reinsertion.h).
  int reinsertions = 0;
};

// The usual hierarchy. Requires: the clipper outlives the build.
BvhBuildConfig usual_build(const PrimitiveClipper& clipper);
// The hierarchy of quality. Requires: the clipper outlives the build.
BvhBuildConfig spatial_build(const PrimitiveClipper& clipper);

}  // namespace tessera::core
