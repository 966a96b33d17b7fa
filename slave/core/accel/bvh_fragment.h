// SPDX-License-Identifier: Apache-2.0
// The binary hierarchy in fragments, each of which one task builds, and the wide nodes that are cut
// out of it (wide_nodes.h).
//
// The first fragment is the top: its leaves are links to the roots of all others. A wide node
// belongs to the fragment that the root of what it stands for lies in; its children may lie in
// other fragments only where it belongs to the top.
//
// Threads. Different threads may grow different fragments, and cut different fragments after the
// top; a thread that cuts reads all binary nodes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "slave/core/accel/box4.h"
#include "slave/core/accel/bvh_build_config.h"
#include "slave/core/accel/bvh_join.h"
#include "slave/core/accel/bvh_layout.h"
#include "slave/core/accel/primitive_set.h"
#include "slave/core/accel/range_splitter.h"
#include "slave/core/accel/wide_nodes.h"

namespace tessera::core {

// The left half of a node stands right behind it.
template <int W>
struct BinaryNode {
  Box4 bounds{};
  std::uint32_t right = 0;           // where its right half stands; 0: it is a leaf
  std::uint32_t begin = 0, end = 0;  // of a leaf: its references
  std::uint32_t linked = 0;          // of a leaf of the top: the fragment whose root it stands for
  SlotPlan<W> plan{};
};

struct Subtree {
  std::uint32_t fragment = 0, node = 0;
};

// A child of the top's wide nodes that lies in the fragment: to be tied to its slot when all is
// put together.
struct Bough {
  std::uint32_t node = 0;              // of the binary hierarchy
  std::uint32_t parent = 0, slot = 0;  // of the top's wide nodes
  std::uint32_t reference = 0;         // what stands there, counted from the fragment's first
};

template <int W>
struct BvhFragment : BvhPart<W> {
  std::vector<BinaryNode<W>> tree{};
  SlotCosts<W> costs{};  // of its root
  std::vector<Bough> boughs{};
};

// Splits ranges down to leaves.
template <int W>
class FragmentGrower {
 public:
  FragmentGrower(const RangeSplitter& splitter, const BvhBuildConfig& config,
                 BvhFragment<W>& fragment)
      : splitter_(splitter), config_(config), tree_(fragment.tree) {}

  // Appends the subtree of a range; recursion is bounded by kBvhDepthMax. Returns: its costs.
  SlotCosts<W> grow(const RefRange& range, int depth) {
    const Branch branch = splitter_.branch_of(range, depth, bins_);
    const auto index = static_cast<std::uint32_t>(tree_.size());
    const float area = branch.range.bounds.half_area();
    const float as_leaf = config_.cost_block * area * splitter_.blocks_of_leaf(branch.range);
    tree_.push_back({branch.range.bounds, 0, branch.range.begin, branch.range.end});
    if (!branch.is_split || splitter_.is_cancelled()) return leaf_costs<W>(as_leaf);
    const bool may_be_leaf = splitter_.may_be_leaf(branch.range);
    const auto [left, right] = splitter_.halves_of(branch);
    const SlotCosts<W> of_left = grow(left, depth + 1);
    tree_[index].right = static_cast<std::uint32_t>(tree_.size());
    const SlotCosts<W> of_right = grow(right, depth + 1);
    const WholeCosts whole{as_leaf, may_be_leaf, config_.cost_node * area};
    return costs_of_halves(of_left, of_right, whole, tree_[index].plan);
  }

 private:
  const RangeSplitter& splitter_;
  const BvhBuildConfig& config_;
  std::vector<BinaryNode<W>>& tree_;
  SahBins bins_;
};

// Cuts wide nodes out of fragments.
template <int W>
class FragmentCutter {
 public:
  FragmentCutter(std::span<BvhFragment<W>> fragments, const RangeSplitter& splitter)
      : fragments_(fragments), splitter_(splitter) {}

  // Makes the root and the other wide nodes of the top, and hands what hangs on them to the
  // fragments.
  void cut_top() {
    const Subtree root = resolved({0, 0});
    Subtree children[W] = {root};
    const int count = node_of(root).plan.is_leaf() ? 1 : children_of(root, children);
    cut_top_node({children, static_cast<std::size_t>(count)});
  }

  // Makes the wide nodes and leaves of a fragment. Requires: cut_top() has returned.
  void cut(std::uint32_t fragment) {
    BvhFragment<W>& out = fragments_[fragment];
    std::vector<std::uint32_t> primitives;
    for (Bough& bough : out.boughs) {
      bough.reference = reference_to({fragment, bough.node}, out, primitives);
    }
  }

 private:
  const BinaryNode<W>& node_of(Subtree subtree) const {
    return fragments_[subtree.fragment].tree[subtree.node];
  }
  Subtree resolved(Subtree subtree) const {
    const std::uint32_t linked = node_of(subtree).linked;
    return linked != 0 ? Subtree{linked, 0} : subtree;
  }

  // Writes the subtrees that take the slots. Returns: where the next one is to be written.
  Subtree* share_out(Subtree subtree, int slots, Subtree* next) const {
    subtree = resolved(subtree);
    const BinaryNode<W>& node = node_of(subtree);
    const int left = slots == 1 ? 0 : node.plan.left[slots - 1];
    if (left == 0) {
      *next = subtree;
      return next + 1;
    }
    next = share_out({subtree.fragment, subtree.node + 1}, left, next);
    return share_out({subtree.fragment, node.right}, slots - left, next);
  }

  // Requires: the subtree does not stand as a leaf. Returns: how many children its wide node has.
  int children_of(Subtree subtree, Subtree (&children)[W]) const {
    const BinaryNode<W>& node = node_of(subtree);
    const int left = node.plan.left[0];
    Subtree* const next = share_out({subtree.fragment, subtree.node + 1}, left, children);
    return static_cast<int>(share_out({subtree.fragment, node.right}, W - left, next) - children);
  }

  static void set_child(BvhNode<W>& node, std::size_t slot, const Box4& box,
                        std::uint32_t reference) {
    for (int a = 0; a < 3; ++a) {
      node.lower[a][slot] = box.lower[a];
      node.upper[a][slot] = box.upper[a];
    }
    node.child[slot] = reference;
  }

  // Appends an empty node. Returns: its number.
  static std::uint32_t append_node(BvhFragment<W>& out) {
    BvhNode<W>& node = out.nodes.emplace_back();
    for (std::size_t slot = 0; slot < W; ++slot) set_child(node, slot, {}, kBvhNoChild);
    return static_cast<std::uint32_t>(out.nodes.size() - 1);
  }

  std::uint32_t cut_top_node(std::span<const Subtree> children) {
    BvhFragment<W>& top = fragments_[0];
    const std::uint32_t index = append_node(top);
    for (std::uint32_t slot = 0; slot < children.size(); ++slot) {
      const Subtree child = children[slot];
      std::uint32_t reference = kBvhNoChild;
      if (child.fragment == 0) {
        Subtree below[W];
        const int count = children_of(child, below);
        reference = cut_top_node({below, static_cast<std::size_t>(count)});
      } else {
        fragments_[child.fragment].boughs.push_back({child.node, index, slot});
      }
      set_child(top.nodes[index], slot, node_of(child).bounds, reference);
    }
    return index;
  }

  std::uint32_t reference_to(Subtree subtree, BvhFragment<W>& out,
                             std::vector<std::uint32_t>& primitives) const {
    if (node_of(subtree).plan.is_leaf()) return make_leaf(subtree, out, primitives);
    const std::uint32_t index = append_node(out);
    Subtree children[W];
    const auto count = static_cast<std::size_t>(children_of(subtree, children));
    for (std::size_t slot = 0; slot < count; ++slot) {
      const std::uint32_t reference = reference_to(children[slot], out, primitives);
      set_child(out.nodes[index], slot, node_of(children[slot]).bounds, reference);
    }
    return index;
  }

  // A leaf may hold ranges that were split, with room between them, and parts of one primitive.
  std::uint32_t make_leaf(Subtree subtree, BvhFragment<W>& out,
                          std::vector<std::uint32_t>& primitives) const {
    const auto& tree = fragments_[subtree.fragment].tree;
    std::uint32_t last = subtree.node;
    while (tree[last].right != 0) last = tree[last].right;
    primitives.clear();
    for (std::uint32_t i = subtree.node; i <= last; ++i) {
      if (tree[i].right != 0) continue;
      for (const PrimitiveRef& ref : splitter_.refs_of(tree[i].begin, tree[i].end))
        primitives.push_back(ref.primitive);
    }
    std::sort(primitives.begin(), primitives.end());
    primitives.erase(std::unique(primitives.begin(), primitives.end()), primitives.end());
    const LeafRange leaf = out.leaves->append(primitives);
    return bvh_leaf_of(leaf.first, leaf.count);
  }

  const std::span<BvhFragment<W>> fragments_;
  const RangeSplitter& splitter_;
};

}  // namespace tessera::core
