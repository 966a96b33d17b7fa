// SPDX-License-Identifier: Apache-2.0
// Moves single instances within the hierarchy that stands over all of them: an instance is taken
// out of its leaf, boxes above shrink, and it is put in where boxes grow least. What that takes
// follows the hierarchy's depth and not the number of instances, beside one pass that finds the
// parents.
//
// After Bittner, Hapala, Havran, "Fast insertion-based optimization of bounding volume
// hierarchies", 2013, which takes nodes out and puts them in for a better hierarchy.
//
// Threads. One owner.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/math/bounds3.h"
#include "slave/core/accel/bvh.h"
#include "slave/core/primitive/shapes_layout.h"

namespace tessera::core {

template <int W>
class TopEdit {
 public:
  // Shape: blocks as TrianglesAndInstances has them, instances alone; boxes [instance_count], as
  // they are after all moves. Requires: the hierarchy is over these instances; boxes outlive it.
  TopEdit(const Bvh<W>& top, std::span<const std::uint32_t> blocks,
          std::span<const Bounds3f> boxes);

  // Puts the instance where its box is now. Returns: false where the hierarchy would become too
  // deep, or a leaf has too many instances to be parted; it has to be built anew then.
  bool move(std::uint32_t instance);

  Bvh<W> take_top();
  std::vector<std::uint32_t> take_blocks() { return std::move(blocks_); }

 private:
  // A place for a child: the node's number times W, and the child's within the node.
  using Slot = std::uint32_t;
  static constexpr Slot kRoot = 0xffffffffu;

  std::uint32_t& child_at(Slot slot) { return nodes_[slot / W].child[slot % W]; }
  Bounds3f box_at(Slot slot) const;
  void set_box(Slot slot, const Bounds3f& box);
  Bounds3f box_of_node(std::uint32_t node) const;
  void take_out(std::uint32_t instance);
  // Sets boxes above to what is below them. A node without children stays, with an empty box.
  void shrink_above(Slot slot);
  bool put_in(std::uint32_t instance);
  // The child of the node that the box enlarges least, or an empty slot.
  Slot best_slot(std::uint32_t node, const Bounds3f& box) const;
  bool put_beside(Slot leaf, std::uint32_t instance, int depth);
  std::uint32_t leaf_of(std::uint32_t instance);

  BvhNodes<W> nodes_;
  std::vector<std::uint32_t> blocks_;
  std::span<const Bounds3f> boxes_;
  std::vector<Slot> parent_;  // [node]; kRoot for the root
  std::vector<Slot> leaf_;    // [instance]: the slot of its leaf
};

}  // namespace tessera::core
