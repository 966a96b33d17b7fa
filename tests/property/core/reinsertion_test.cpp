// SPDX-License-Identifier: Apache-2.0
// Property: whatever the tree, what is left after subtrees have moved is a tree of the same leaves
// whose boxes fit and whose areas are no more in all.
#include "slave/core/accel/reinsertion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace tessera::core {
namespace {

using Tree = std::vector<LooseNode>;

Box4 box_at(const float (&lower)[3], float size) {
  alignas(16) const float low[4] = {lower[0], lower[1], lower[2], 0};
  Box4 box;
  box.grow(load4(low), load4(low) + splat4(size));
  return box;
}

// A tree over leaves in the order that they have, each range halved in the middle.
std::uint32_t halve(const std::vector<Box4>& leaves, std::size_t begin, std::size_t end,
                    Tree& tree) {
  const auto index = static_cast<std::uint32_t>(tree.size());
  tree.emplace_back();
  if (end - begin == 1) {
    tree[index].bounds = leaves[begin];
    return index;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const std::uint32_t left = halve(leaves, begin, middle, tree);
  const std::uint32_t right = halve(leaves, middle, end, tree);
  tree[index].child[0] = left;
  tree[index].child[1] = right;
  for (const std::uint32_t child : {left, right}) {
    tree[child].parent = index;
    tree[index].bounds.grow(tree[child].bounds);
  }
  return index;
}

Tree tree_of(const std::vector<Box4>& leaves) {
  Tree tree;
  halve(leaves, 0, leaves.size(), tree);
  return tree;
}

std::vector<Box4> random_boxes(std::uint32_t seed, int count, float size) {
  std::mt19937 random(seed);
  const auto in_unit = [&] { return 0x1p-32f * static_cast<float>(random()); };
  std::vector<Box4> boxes;
  for (int i = 0; i < count; ++i) {
    const float lower[3] = {in_unit(), in_unit(), in_unit()};
    boxes.push_back(box_at(lower, size * in_unit()));
  }
  return boxes;
}

double area_of_inner(const Tree& tree) {
  double sum = 0;
  for (const LooseNode& node : tree) {
    if (!node.is_leaf()) sum += double{node.bounds.half_area()};
  }
  return sum;
}

void expect_same_box(const Box4& a, const Box4& b) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(a.lower[axis], b.lower[axis]);
    EXPECT_EQ(a.upper[axis], b.upper[axis]);
  }
}

// Walks the whole tree; `before` had the same leaves.
void expect_sound(const Tree& tree, const Tree& before) {
  ASSERT_EQ(tree.size(), before.size());
  std::vector<std::uint32_t> open{0};
  std::vector<int> met(tree.size(), 0);
  while (!open.empty()) {
    const std::uint32_t index = open.back();
    open.pop_back();
    ASSERT_EQ(met[index]++, 0) << "node " << index << " is met twice";
    const LooseNode& node = tree[index];
    EXPECT_EQ(node.is_leaf(), before[index].is_leaf());
    if (node.is_leaf()) {
      expect_same_box(node.bounds, before[index].bounds);
      continue;
    }
    Box4 box;
    for (const std::uint32_t child : node.child) {
      ASSERT_LT(child, tree.size());
      EXPECT_EQ(tree[child].parent, index);
      box.grow(tree[child].bounds);
      open.push_back(child);
    }
    expect_same_box(node.bounds, box);
  }
  EXPECT_EQ(std::count(met.begin(), met.end(), 1), static_cast<std::ptrdiff_t>(tree.size()));
}

bool never() { return false; }

TEST(Reinsertion, KeepsATreeOfTheSameLeaves) {
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    const int count = 1 + static_cast<int>(seed * seed % 700);
    const float size = seed % 3 == 0 ? 1.0f : seed % 3 == 1 ? 0.05f : 0.0f;
    const Tree before = tree_of(random_boxes(seed, count, size));
    Tree tree = before;
    reinsert_subtrees(tree, 2, never);
    expect_sound(tree, before);
    EXPECT_LE(area_of_inner(tree), area_of_inner(before));
    if (size == 0.05f && count > 100) {
      EXPECT_LT(area_of_inner(tree), 0.8 * area_of_inner(before));
    }
  }
}

// Two rows of boxes far from each other, and one of the right row stands among the left one's.
TEST(Reinsertion, BringsBackWhatStandsOnTheWrongSide) {
  std::vector<Box4> leaves;
  for (int i = 0; i < 16; ++i) {
    const bool is_right = i >= 8 || i == 5;
    const float lower[3] = {is_right ? 1000.0f : 0.0f, 2 * static_cast<float>(i % 8), 0};
    leaves.push_back(box_at(lower, 1));
  }
  const Tree before = tree_of(leaves);
  Tree tree = before;
  reinsert_subtrees(tree, 2, never);
  expect_sound(tree, before);
  for (const std::uint32_t half : tree[0].child)
    EXPECT_LT(tree[half].bounds.upper[0] - tree[half].bounds.lower[0], 2);
}

TEST(Reinsertion, LeavesTreesAloneWhereNothingIsGained) {
  const float origin[3] = {0, 0, 0};
  const float far_off[3] = {-1e25f, 0, 0};
  std::vector<Box4> infinite = random_boxes(3, 200, 0.1f);
  infinite.push_back(box_at(far_off, 2e25f));
  for (const Tree& before :
       {tree_of({box_at(origin, 1)}), tree_of(random_boxes(1, 2, 0.5f)),
        tree_of(std::vector<Box4>(300, box_at(origin, 1))),
        tree_of(std::vector<Box4>(300, box_at(origin, 0))), tree_of(infinite)}) {
    Tree tree = before;
    reinsert_subtrees(tree, 2, never);
    expect_sound(tree, before);
    for (std::size_t i = 0; i < tree.size(); ++i) EXPECT_EQ(tree[i].parent, before[i].parent);
  }
}

TEST(Reinsertion, StopsBetweenMoves) {
  const Tree before = tree_of(random_boxes(5, 4000, 0.05f));
  for (int most = 0; most < 20; most += 3) {
    Tree tree = before;
    int asked = 0;
    reinsert_subtrees(tree, 3, [&] { return asked++ == most; });
    EXPECT_EQ(asked, most + 1);
    expect_sound(tree, before);
  }
}

}  // namespace
}  // namespace tessera::core
