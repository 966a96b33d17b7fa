// SPDX-License-Identifier: Apache-2.0
// Parameters of a kd-tree build: costs of the surface area heuristic, and bounds.
//
// Threads. Values.
#pragma once

#include <cstddef>
#include <cstdint>

#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

inline constexpr int kKdBinsMax = 128;

struct KdBuildConfig {
  float cost_traverse = 1.0f;  // cost of one step down, the unit
  // Cost of one primitive's test, in a block that has a box; measured (decisions/kd-tree.md).
  float cost_intersect = 0.006f;
  float empty_bonus = 0.2f;  // share of cost forgiven to a split that cuts empty space off
  std::uint32_t refs_per_primitive_max = 8;  // on average; bounds the memory of leaves
  // In voxels of at most this many primitives, planes are tried at every face of a box; in larger
  // ones at the borders of bins, and at every face in the two bins beside the best border.
  std::size_t sweep_max = 32;
  int bin_count = 32;  // at most kKdBinsMax
  // Trying the faces beside the best border takes time and pays mostly in large voxels. It is done
  // only for at least `refine_min` primitives, and only where those faces are at most
  // `refine_share` of all faces.
  std::size_t refine_min = 8192;
  float refine_share = 0.15f;
  const PrimitiveClipper* clipper = nullptr;  // null: boxes are enough
};

}  // namespace tessera::core
