// SPDX-License-Identifier: Apache-2.0
// Moves subtrees of a fragment to better places, and lays the fragment out anew.
//
// Threads. Different threads may work on different fragments.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "slave/core/accel/bvh_build_config.h"
#include "slave/core/accel/bvh_fragment.h"
#include "slave/core/accel/range_splitter.h"
#include "slave/core/accel/reinsertion.h"

namespace tessera::core {

template <int W>
class FragmentMover {
 public:
  FragmentMover(const RangeSplitter& splitter, const BvhBuildConfig& config,
                BvhFragment<W>& fragment)
      : splitter_(splitter), config_(config), fragment_(fragment) {}

  // `depth`: where the fragment's root lies in the whole. A fragment that would lie too deep stays
  // as it was.
  void move(int depth) {
    std::vector<LooseNode> nodes = loosened();
    reinsert_subtrees(nodes, config_.reinsertions, [this] { return splitter_.is_cancelled(); });
    if (depth + depth_of(nodes) > kBvhDepthMax) return;
    tree_.reserve(nodes.size());
    fragment_.costs = lay_out(nodes, 0).costs;
    fragment_.tree = std::move(tree_);
  }

 private:
  // A subtree that stands in the new order.
  struct Laid {
    SlotCosts<W> costs;
    std::uint32_t size;  // references
    bool may_be_leaf;
  };

  std::vector<LooseNode> loosened() const {
    const auto& tree = fragment_.tree;
    std::vector<LooseNode> nodes(tree.size());
    for (std::uint32_t i = 0; i < tree.size(); ++i) {
      nodes[i].bounds = tree[i].bounds;
      if (tree[i].right == 0) continue;
      nodes[i].child[0] = i + 1;
      nodes[i].child[1] = tree[i].right;
      nodes[i + 1].parent = nodes[tree[i].right].parent = i;
    }
    return nodes;
  }

  static int depth_of(const std::vector<LooseNode>& nodes) {
    std::vector<std::pair<std::uint32_t, int>> open{{0, 0}};
    int deepest = 0;
    while (!open.empty()) {
      const auto [node, depth] = open.back();
      open.pop_back();
      deepest = std::max(deepest, depth);
      if (nodes[node].is_leaf()) continue;
      for (const std::uint32_t child : nodes[node].child) open.push_back({child, depth + 1});
    }
    return deepest;
  }

  // Appends a subtree; recursion is bounded by kBvhDepthMax.
  Laid lay_out(const std::vector<LooseNode>& nodes, std::uint32_t from) {
    const LooseNode& node = nodes[from];
    const float area = node.bounds.half_area();
    RefRange range;
    if (node.is_leaf()) {
      const BinaryNode<W>& leaf = fragment_.tree[from];
      range.begin = leaf.begin;
      range.end = leaf.end;
      tree_.push_back(leaf);
      return {leaf_costs<W>(cost_as_leaf(range, area)), range.size(), splitter_.may_be_leaf(range)};
    }
    const auto index = static_cast<std::uint32_t>(tree_.size());
    tree_.push_back({node.bounds});
    const Laid left = lay_out(nodes, node.child[0]);
    tree_[index].right = static_cast<std::uint32_t>(tree_.size());
    const Laid right = lay_out(nodes, node.child[1]);
    range.end = left.size + right.size;
    const bool may_be_leaf =
        left.may_be_leaf && right.may_be_leaf && range.size() <= W * kBvhLeafBlocksMax;
    const WholeCosts whole{cost_as_leaf(range, area), may_be_leaf, config_.cost_node * area};
    return {costs_of_halves(left.costs, right.costs, whole, tree_[index].plan), range.size(),
            may_be_leaf};
  }

  float cost_as_leaf(const RefRange& range, float area) const {
    return config_.cost_block * area * splitter_.blocks_of_leaf(range);
  }

  const RangeSplitter& splitter_;
  const BvhBuildConfig& config_;
  BvhFragment<W>& fragment_;
  std::vector<BinaryNode<W>> tree_;
};

}  // namespace tessera::core
