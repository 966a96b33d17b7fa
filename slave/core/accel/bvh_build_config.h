// SPDX-License-Identifier: Apache-2.0
// How a wide bounding volume hierarchy is to be built, beside the number of threads.
//
// Threads. Plain values.
#pragma once

#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

struct BvhBuildConfig {
  float cost_node = 1.0f;   // testing the boxes of a wide node, the unit
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
inline BvhBuildConfig spatial_build(const PrimitiveClipper& clipper) {
  BvhBuildConfig config;
  config.clipper = &clipper;
  config.counts_primitives = true;
  return config;
}

}  // namespace tessera::core
