// SPDX-License-Identifier: Apache-2.0
// Property: of all ways to cut a binary hierarchy into wide nodes, the one that is chosen costs
// least: it is compared with all of them, on small trees.
#include "slave/core/accel/wide_nodes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace tessera::core {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A node of a tree, the leaves of which have no halves. Costs are whole numbers, so that sums are
// exact in any order.
struct Node {
  int left = -1, right = -1;
  WholeCosts whole{};
};

using Tree = std::vector<Node>;  // the root first
using Cut = std::vector<int>;    // nodes that hold each leaf below a node once

// All cuts of the subtree at `node`.
std::vector<Cut> cuts_of(const Tree& tree, int node) {
  const Node& at = tree[static_cast<std::size_t>(node)];
  std::vector<Cut> cuts{{node}};
  if (at.left < 0) return cuts;
  for (const Cut& left : cuts_of(tree, at.left)) {
    for (const Cut& right : cuts_of(tree, at.right)) {
      cuts.push_back(left);
      cuts.back().insert(cuts.back().end(), right.begin(), right.end());
    }
  }
  return cuts;
}

// The least cost of a tree's subtrees, by looking at every cut.
struct BruteForce {
  const Tree& tree;
  std::size_t width;

  float standing(int node) const {
    const Node& at = tree[static_cast<std::size_t>(node)];
    const float as_leaf = at.whole.may_be_leaf ? at.whole.as_leaf : kInfinity;
    if (at.left < 0) return as_leaf;
    float below = kInfinity;
    for (const Cut& cut : cuts_of(tree, node)) {
      if (cut.size() > 1 && cut.size() <= width) below = std::min(below, sum(cut));
    }
    return std::min(as_leaf, at.whole.as_node + below);
  }
  float in_slots(int node, std::size_t slots) const {
    float least = kInfinity;
    for (const Cut& cut : cuts_of(tree, node)) {
      if (cut.size() <= slots) least = std::min(least, sum(cut));
    }
    return least;
  }
  float sum(const Cut& cut) const {
    float all = 0;
    for (const int node : cut) all += standing(node);
    return all;
  }
};

// The plans of a tree, and the costs of its subtrees.
template <int W>
struct Planned {
  const Tree& tree;
  std::vector<SlotCosts<W>> costs;
  std::vector<SlotPlan<W>> plans;

  explicit Planned(const Tree& of) : tree(of), costs(of.size()), plans(of.size()) {
    for (std::size_t i = tree.size(); i-- > 0;) {
      const Node& node = tree[i];
      costs[i] = node.left < 0 ? leaf_costs<W>(node.whole.as_leaf)
                               : costs_of_halves(costs[static_cast<std::size_t>(node.left)],
                                                 costs[static_cast<std::size_t>(node.right)],
                                                 node.whole, plans[i]);
    }
  }
  // Nodes that stand whole where the subtree takes so many slots.
  void share_out(int node, int slots, Cut& cut) const {
    const Node& at = tree[static_cast<std::size_t>(node)];
    const int left = slots == 1 ? 0 : plans[static_cast<std::size_t>(node)].left[slots - 1];
    if (left == 0) return cut.push_back(node);
    ASSERT_LT(left, slots);
    share_out(at.left, left, cut);
    share_out(at.right, slots - left, cut);
  }
  Cut children_of(int node) const {
    const int left = plans[static_cast<std::size_t>(node)].left[0];
    Cut children;
    share_out(tree[static_cast<std::size_t>(node)].left, left, children);
    share_out(tree[static_cast<std::size_t>(node)].right, W - left, children);
    return children;
  }
  // What the wide hierarchy costs that the plans lead to.
  float cost_of(int node, int depth) const {
    const Node& at = tree[static_cast<std::size_t>(node)];
    EXPECT_LE(depth, static_cast<int>(tree.size()));
    if (plans[static_cast<std::size_t>(node)].is_leaf()) {
      EXPECT_TRUE(at.whole.may_be_leaf);
      return at.whole.as_leaf;
    }
    const Cut children = children_of(node);
    EXPECT_GE(children.size(), 2U);
    EXPECT_LE(children.size(), static_cast<std::size_t>(W));
    float all = at.whole.as_node;
    for (const int child : children) all += cost_of(child, depth + 1);
    return all;
  }
};

// A tree of so many leaves in which a half has any share of them. Costs do not grow towards the
// root, as they do in hierarchies: what is chosen must not rest on that.
void grow(Tree& tree, int leaf_count, std::mt19937& random) {
  const auto whole_number = [&random](unsigned below) {
    return static_cast<float>(random() % below);
  };
  const std::size_t index = tree.size();
  tree.push_back({-1, -1, {1 + whole_number(30), true, 1 + whole_number(10)}});
  if (leaf_count == 1) return;
  tree[index].whole.as_leaf += whole_number(20) * static_cast<float>(leaf_count);
  tree[index].whole.may_be_leaf = random() % 3 != 0;
  const int of_left = 1 + static_cast<int>(random() % static_cast<unsigned>(leaf_count - 1));
  tree[index].left = static_cast<int>(tree.size());
  grow(tree, of_left, random);
  tree[index].right = static_cast<int>(tree.size());
  grow(tree, leaf_count - of_left, random);
}

template <int W>
void expect_least_costs(const Tree& tree) {
  const Planned<W> planned(tree);
  const BruteForce all{tree, W};
  for (int n = 1; n < W; ++n) {
    EXPECT_EQ(planned.costs[0].in[n - 1], all.in_slots(0, static_cast<std::size_t>(n))) << n;
  }
  EXPECT_EQ(planned.cost_of(0, 0), all.standing(0));
}

TEST(WideNodes, CostAsLittleAsTheBestOfAllCuts) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Tree tree;
    grow(tree, 1 + static_cast<int>(random() % 8), random);
    expect_least_costs<2>(tree);
    expect_least_costs<3>(tree);
    expect_least_costs<4>(tree);
    expect_least_costs<8>(tree);
    expect_least_costs<16>(tree);
  }
}

// Boxes in a line have no area, those of huge scenes an infinite one.
TEST(WideNodes, AreSoundWhereAllCostsAreEqual) {
  for (const float cost : {0.0f, kInfinity}) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      std::mt19937 random(seed);
      Tree tree;
      grow(tree, 100, random);
      for (Node& node : tree) {
        node.whole = {cost, node.left < 0 || node.whole.may_be_leaf, cost};
      }
      EXPECT_EQ(Planned<8>(tree).cost_of(0, 0), cost);
      EXPECT_EQ(Planned<16>(tree).cost_of(0, 0), cost);
    }
  }
}

// Halves that are far apart stand by themselves where there is a slot for each of them, for what is
// between them is not to be entered.
TEST(WideNodes, SplitALeafWhereItsHalvesAreSmall) {
  const Tree apart{{1, 2, {10, true, 10}}, {-1, -1, {3, true, 0}}, {-1, -1, {4, true, 0}}};
  const Planned<8> planned(apart);
  EXPECT_EQ(planned.costs[0].in[0], 10);
  EXPECT_EQ(planned.costs[0].in[1], 7);
  EXPECT_EQ(planned.costs[0].in[6], 7);
  EXPECT_TRUE(planned.plans[0].is_leaf());
}

}  // namespace
}  // namespace tessera::core
