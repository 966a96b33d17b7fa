// SPDX-License-Identifier: Apache-2.0
// Which nodes of a binary hierarchy become children of wide nodes: those of least cost in all.
//
// Method. From the leaves up, the least cost of each subtree is found for every number of slots of
// a wide node that it may take; from the root down, slots are shared out as these costs were found.
// Ylitie, Karras, Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs",
// 2017, section 3; Pinto, "Adaptive collapsing on bounding volume hierarchies for ray-tracing",
// 2010.
//
// Threads. Pure functions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace tessera::core {

// What the kinds of wide children that a subtree may stand as cost.
struct WholeCosts {
  float as_leaf = 0;        // all its primitives in one leaf
  bool may_be_leaf = true;  // where not, as_leaf does not count
  float as_node = 0;        // the boxes of a node; what lies below comes on top
};

// The least costs of a subtree.
template <int W>
struct SlotCosts {
  float in[W];        // [n - 1]: in at most n slots
  int slots_max = 1;  // more slots are of no use; at most W
};

// How a subtree takes the slots that it is given.
template <int W>
struct SlotPlan {
  // [n - 1], n > 1: of n slots, those of its left half; the other half takes the rest. 0: it stands
  // whole in one. [0]: how it stands whole: as a node of W slots, those of its left half; 0: as a
  // leaf.
  std::uint8_t left[W] = {};

  bool is_leaf() const { return left[0] == 0; }
};

// A leaf of the binary hierarchy.
template <int W>
SlotCosts<W> leaf_costs(float as_leaf) {
  SlotCosts<W> costs;
  std::fill_n(costs.in, W, as_leaf);
  return costs;
}

// Where costs are equal, as where all areas are 0 or infinite, a leaf is chosen before a node, a
// whole before its halves, and few slots for the left half before many. Areas are not NaN.
template <int W>
SlotCosts<W> costs_of_halves(const SlotCosts<W>& left, const SlotCosts<W>& right,
                             const WholeCosts& whole, SlotPlan<W>& plan) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  // Costs of the right half in n - k slots, for all n and one k, are a run of these.
  float shifted[2 * W];
  std::fill_n(shifted, W, kInfinity);
  std::copy_n(right.in, W, shifted + W);
  float halves[W];  // [n - 1]: split over n slots
  std::int32_t from[W];
  std::fill_n(halves, W, kInfinity);
  std::fill_n(from, W, 1);
  for (int k = 1; k <= std::min(left.slots_max, W - 1); ++k) {
    const float* const of_right = shifted + (W - k);
    const float of_left = left.in[k - 1];
    for (int i = 0; i < W; ++i) {
      const float cost = of_left + of_right[i];
      from[i] = cost < halves[i] ? k : from[i];
      halves[i] = std::min(cost, halves[i]);
    }
  }
  const float as_node = whole.as_node + halves[W - 1];
  const bool is_leaf = whole.may_be_leaf && whole.as_leaf <= as_node;
  const float stands = is_leaf ? whole.as_leaf : as_node;
  SlotCosts<W> costs;
  costs.slots_max = std::min(left.slots_max + right.slots_max, W);
  costs.in[0] = stands;
  plan.left[0] = static_cast<std::uint8_t>(is_leaf ? 0 : from[W - 1]);
  for (int i = 1; i < W; ++i) {
    const bool is_whole = stands <= halves[i];
    costs.in[i] = is_whole ? stands : halves[i];
    plan.left[i] = static_cast<std::uint8_t>(is_whole ? 0 : from[i]);
  }
  return costs;
}

}  // namespace tessera::core
