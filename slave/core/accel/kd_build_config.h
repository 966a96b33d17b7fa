// SPDX-License-Identifier: Apache-2.0
// What a kd-tree is built by: costs of the surface area heuristic and bounds.
//
// Threads. Values.
#pragma once

#include <cstddef>
#include <cstdint>

#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

inline constexpr int kKdBinsMax = 128;

struct KdBuildConfig {
  float cost_traverse = 1.0f;     // cost of one step down, the unit
  float cost_intersect = 0.025f;  // cost of one primitive's test, in a block; measured (README.md)
  std::uint32_t block_size = 8;   // primitives of a leaf are tested in blocks of this many
  float empty_bonus = 0.2f;       // share of cost forgiven to a split that cuts empty space off
  std::uint32_t refs_per_primitive_max = 8;  // on average; bounds the memory of leaves
  // In voxels of at most so many primitives planes are tried at every face of a box; above at the
  // borders of bins, and at every face in the two bins beside the best border.
  std::size_t sweep_max = 32;
  int bin_count = 32;  // at most kKdBinsMax
  // The latter takes time, and pays in large voxels above all: only from so many primitives on, and
  // where those faces are at most this share of all.
  std::size_t refine_min = 8192;
  float refine_share = 0.15f;
  const PrimitiveClipper* clipper = nullptr;  // null: boxes are enough
};

}  // namespace tessera::core
