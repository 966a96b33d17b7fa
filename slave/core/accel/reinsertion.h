// SPDX-License-Identifier: Apache-2.0
// Makes a binary hierarchy better that was split from the root down: subtrees are taken out, and
// put in again where the boxes of inner nodes are smallest in all.
//
// Method. Bittner, Hapala, Havran, "Fast insertion-based optimization of bounding volume
// hierarchies", 2013; places are searched from a subtree's own place upwards, as in Meister,
// Bittner, "Parallel reinsertion for bounding volume hierarchy optimization", 2018, but one subtree
// after the other, so that moves never get in each other's way.
//
// Threads. Different threads may work on different trees.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "slave/core/accel/box4.h"

namespace tessera::core {

// A node of a binary tree whose subtrees may move. The root is node 0.
struct LooseNode {
  Box4 bounds{};
  std::uint32_t parent = 0;     // of the root: 0
  std::uint32_t child[2] = {};  // both 0: a leaf

  bool is_leaf() const { return child[0] == 0; }
};

// Moves subtrees below the root; leaves keep their numbers. Each pass tries all nodes in turn.
// `is_to_stop` is asked now and then; what is left after a stop is a tree of the same leaves.
void reinsert_subtrees(std::span<LooseNode> nodes, int passes,
                       const std::function<bool()>& is_to_stop);

}  // namespace tessera::core
