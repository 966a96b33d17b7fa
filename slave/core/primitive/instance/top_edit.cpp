// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/instance/top_edit.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "slave/core/accel/bvh_children.h"

namespace tessera::core {
namespace {

// In double, so that no box overflows it.
double half_area(const Bounds3f& box) {
  if (box.is_empty()) return 0;
  const double x = double{box.upper.x} - double{box.lower.x};
  const double y = double{box.upper.y} - double{box.lower.y};
  const double z = double{box.upper.z} - double{box.lower.z};
  return x * y + y * z + z * x;
}

Bounds3f united(Bounds3f box, const Bounds3f& other) {
  box.grow(other);
  return box;
}

}  // namespace

template <int W>
TopEdit<W>::TopEdit(const Bvh<W>& top, std::span<const std::uint32_t> blocks,
                    std::span<const Bounds3f> boxes)
    : nodes_(top.nodes),
      blocks_(blocks.begin(), blocks.end()),
      boxes_(boxes),
      parent_(top.nodes.size(), kRoot),
      leaf_(boxes.size(), kRoot) {
  for (Slot slot = 0; slot < nodes_.size() * W; ++slot) {
    const std::uint32_t child = child_at(slot);
    if (child == kBvhNoChild) continue;
    if (!is_bvh_leaf(child)) {
      parent_[child] = slot;
      continue;
    }
    for (std::uint32_t b = 0; b < block_count_of(child); ++b)
      leaf_[blocks_[first_block_of(child) + b] ^ kIsItem] = slot;
  }
}

template <int W>
bool TopEdit<W>::move(std::uint32_t instance) {
  take_out(instance);
  return put_in(instance);
}

template <int W>
Bvh<W> TopEdit<W>::take_top() {
  const Bounds3f bounds = box_of_node(0);
  return {bounds, std::move(nodes_)};
}

template <int W>
Bounds3f TopEdit<W>::box_at(Slot slot) const {
  return child_box(nodes_[slot / W], static_cast<int>(slot % W));
}

template <int W>
void TopEdit<W>::set_box(Slot slot, const Bounds3f& box) {
  BvhNode<W>& node = nodes_[slot / W];
  for (int a = 0; a < 3; ++a) {
    node.lower[a][slot % W] = box.lower[a];
    node.upper[a][slot % W] = box.upper[a];
  }
}

template <int W>
Bounds3f TopEdit<W>::box_of_node(std::uint32_t node) const {
  Bounds3f box;
  for (std::uint32_t i = 0; i < W; ++i) box.grow(box_at(node * W + i));
  return box;
}

// Blocks of a leaf ascend, so those behind the one that goes move up.
template <int W>
void TopEdit<W>::take_out(std::uint32_t instance) {
  const Slot slot = leaf_[instance];
  const std::uint32_t leaf = child_at(slot), first = first_block_of(leaf),
                      count = block_count_of(leaf);
  const auto begin = blocks_.begin() + first, end = begin + count;
  std::move(std::find(begin, end, instance | kIsItem) + 1, end,
            std::find(begin, end, instance | kIsItem));
  child_at(slot) = count == 1 ? kBvhNoChild : bvh_leaf_of(first, count - 1);
  Bounds3f box;
  for (std::uint32_t b = first; b < first + count - 1; ++b) box.grow(boxes_[blocks_[b] ^ kIsItem]);
  set_box(slot, box);
  shrink_above(slot);
}

template <int W>
void TopEdit<W>::shrink_above(Slot slot) {
  for (Slot above = parent_[slot / W]; above != kRoot; above = parent_[above / W])
    set_box(above, box_of_node(child_at(above)));
}

template <int W>
typename TopEdit<W>::Slot TopEdit<W>::best_slot(std::uint32_t node, const Bounds3f& box) const {
  Slot best = node * W;
  double least = std::numeric_limits<double>::infinity();
  for (Slot slot = node * W; slot < (node + 1) * W; ++slot) {
    const Bounds3f now = box_at(slot);
    const double growth = half_area(united(now, box)) - half_area(now);
    if (!(growth < least)) continue;
    least = growth;
    best = slot;
  }
  return best;
}

template <int W>
std::uint32_t TopEdit<W>::leaf_of(std::uint32_t instance) {
  blocks_.push_back(instance | kIsItem);
  return bvh_leaf_of(static_cast<std::uint32_t>(blocks_.size() - 1), 1);
}

// A leaf of one instance takes an empty slot for nothing, since all boxes of a node are tested at
// once; so that is where it goes before another leaf is joined.
template <int W>
bool TopEdit<W>::put_in(std::uint32_t instance) {
  if (blocks_.size() + W > kBvhBlockMask) return false;
  const Bounds3f& box = boxes_[instance];
  std::uint32_t node = 0;
  for (int depth = 0;; ++depth) {
    Slot slot = best_slot(node, box);
    if (is_bvh_leaf(child_at(slot))) {
      const std::uint32_t* const children = nodes_[node].child;
      const auto* const free = std::find(children, children + W, kBvhNoChild);
      if (free == children + W) return put_beside(slot, instance, depth + 1);
      slot = node * W + static_cast<Slot>(free - children);
    }
    if (child_at(slot) == kBvhNoChild) {
      child_at(slot) = leaf_of(instance);
      set_box(slot, box);
      leaf_[instance] = slot;
      return true;
    }
    set_box(slot, united(box_at(slot), box));
    node = child_at(slot);
  }
}

// Makes a node of the leaf, in which each of its instances and the new one are leaves.
template <int W>
bool TopEdit<W>::put_beside(Slot slot, std::uint32_t instance, int depth) {
  const std::uint32_t leaf = child_at(slot), first = first_block_of(leaf),
                      count = block_count_of(leaf);
  if (depth > kBvhDepthMax || count + 1 > W) return false;
  const auto node = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  parent_.push_back(slot);
  const auto put = [&](std::uint32_t i, std::uint32_t child, const Bounds3f& box) {
    nodes_[node].child[i] = child;
    set_box(node * W + i, box);
  };
  for (std::uint32_t i = 0; i < W; ++i) put(i, kBvhNoChild, {});
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t other = blocks_[first + i] ^ kIsItem;
    put(i, bvh_leaf_of(first + i, 1), boxes_[other]);
    leaf_[other] = node * W + i;
  }
  put(count, leaf_of(instance), boxes_[instance]);
  leaf_[instance] = node * W + count;
  child_at(slot) = node;
  set_box(slot, united(box_at(slot), boxes_[instance]));
  return true;
}

template class TopEdit<8>;
template class TopEdit<16>;

}  // namespace tessera::core
