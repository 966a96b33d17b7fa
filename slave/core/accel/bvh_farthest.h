// SPDX-License-Identifier: Apache-2.0
// How far along an axis something in a hierarchy reaches, where boxes of nodes are only bounds of
// it: a search that goes down only where something may reach farther than the best so far.
//
// Units: those of whoever measures boxes; for places, the world's.
// Threads. Pure functions.
#pragma once

#include <cstdint>
#include <limits>
#include <queue>
#include <utility>

#include "slave/core/accel/bvh_children.h"

namespace tessera::core {

// One of the six directions along the axes; of() is the coordinate along it.
struct AxisDirection {
  int axis;
  float sign;

  float of(Vec3f p) const { return p[axis] * sign; }
  float of(const Bounds3f& box) const { return of(sign > 0 ? box.upper : box.lower); }
};

// best: how far is reached at least. reach_of(box): how far what is in a node's box may reach.
// best_in_leaf(leaf, best): the greater of best and how far what is in the leaf reaches.
// Requires: there is a node. Returns: the greatest reach.
// Throws: what the two throw; std::bad_alloc.
template <int W, class ReachOf, class BestInLeaf>
float farthest_in_bvh(const BvhNode<W>* nodes, float best, const ReachOf& reach_of,
                      const BestInLeaf& best_in_leaf) {
  std::priority_queue<std::pair<float, std::uint32_t>> open;  // the farthest first
  open.push({std::numeric_limits<float>::infinity(), 0});
  while (!open.empty() && open.top().first > best) {
    const std::uint32_t child = open.top().second;
    open.pop();
    if (is_bvh_leaf(child)) {
      best = best_in_leaf(child, best);
      continue;
    }
    const BvhNode<W>& node = nodes[child];
    for (int i = 0; i < W; ++i) {
      if (node.child[i] != kBvhNoChild) open.push({reach_of(child_box(node, i)), node.child[i]});
    }
  }
  return best;
}

}  // namespace tessera::core
