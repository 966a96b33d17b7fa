// SPDX-License-Identifier: Apache-2.0
// What the words of a wide node say (bvh_layout.h), for the plain code that builds, checks and
// edits hierarchies; kernels have their own forms.
//
// Threads. Pure functions.
#pragma once

#include <cstdint>

#include "common/math/bounds3.h"
#include "slave/core/accel/bvh_layout.h"

namespace tessera::core {

inline bool is_bvh_leaf(std::uint32_t child) {
  return child != kBvhNoChild && (child & kBvhLeaf) != 0;
}
// Requires, of these two: is_bvh_leaf(child).
inline std::uint32_t first_block_of(std::uint32_t child) { return child & kBvhBlockMask; }
inline std::uint32_t block_count_of(std::uint32_t child) {
  return (child >> kBvhCountShift & (kBvhLeafBlocksMax - 1)) + 1;
}
// Requires: 1 <= count <= kBvhLeafBlocksMax, first <= kBvhBlockMask.
inline std::uint32_t bvh_leaf_of(std::uint32_t first, std::uint32_t count) {
  return kBvhLeaf | (count - 1) << kBvhCountShift | first;
}

// Empty where there is no child.
template <int W>
Bounds3f child_box(const BvhNode<W>& node, int slot) {
  return {{node.lower[0][slot], node.lower[1][slot], node.lower[2][slot]},
          {node.upper[0][slot], node.upper[1][slot], node.upper[2][slot]}};
}

}  // namespace tessera::core
