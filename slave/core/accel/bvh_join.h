// SPDX-License-Identifier: Apache-2.0
// Puts the parts of a hierarchy, each of which one task built, into one.
//
// Threads. A call works on several threads; parts are freed as they are copied.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/work_gate.h"
#include "slave/core/accel/bvh.h"
#include "slave/core/accel/bvh_children.h"
#include "slave/core/accel/primitive_set.h"
#include "slave/core/accel/run_tasks.h"

namespace tessera::core {

// Numbers of nodes and blocks count from the part's own first ones.
template <int W>
struct BvhPart {
  BvhNodes<W> nodes{};
  std::unique_ptr<LeafWriter> leaves{};  // null: it has none
};

// Makes room in a part for so many blocks and their nodes, before a task builds it: a good guess
// saves most of the moves of growing arrays. To be called on the owner's thread: glibc keeps what
// is freed to the heap of the main thread, and unmaps that of others, whose pages each build would
// touch for the first time. Throws: std::bad_alloc.
template <int W>
void make_room(const LeafWriter& leaves, std::size_t blocks, BvhPart<W>& part) {
  part.leaves = leaves.fresh();
  part.leaves->reserve(blocks);
  part.nodes.reserve(blocks / (W / 2) + 1);
}

// By how much the numbers of a part grow.
struct PartBase {
  std::uint32_t node = 0, block = 0;

  std::uint32_t moved(std::uint32_t child) const {
    return child + (is_bvh_leaf(child) ? block : node);
  }
};

// Moves the nodes of all parts into `bvh` and their blocks into the leaves of `set`, both empty, in
// turn; leaves the parts empty. Part: a BvhPart, or what extends it. Returns: the base of each
// part; kResourceExhausted where leaves cannot name so many blocks. Throws: std::bad_alloc.
template <int W, class Part>
Result<std::vector<PartBase>> join_parts(std::span<Part> parts, const PrimitiveSet& set,
                                         int thread_count, Bvh<W>& bvh) {
  std::vector<PartBase> bases(parts.size());
  std::vector<LeafWriter*> writers;
  std::size_t node_count = 0, block_count = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    bases[i].node = static_cast<std::uint32_t>(node_count);
    node_count += parts[i].nodes.size();
    if (parts[i].leaves == nullptr) continue;
    block_count += parts[i].leaves->block_count();
    writers.push_back(parts[i].leaves.get());
  }
  if (block_count > kBvhBlockMask) {
    return Status::resource_exhausted("the spatial index of " + std::to_string(set.boxes.size()) +
                                      " primitives has more than 2^27 blocks: split the scene");
  }
  const std::vector<std::uint32_t> first_blocks = set.leaves.make_room(writers);
  auto first_block = first_blocks.begin();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].leaves != nullptr) bases[i].block = *first_block++;
  }
  bvh.nodes.resize(node_count);
  run_tasks(static_cast<int>(parts.size()), thread_count, [&](int i) {
    give_way();
    const auto number = static_cast<std::size_t>(i);
    BvhPart<W> part{std::move(parts[number].nodes), std::move(parts[number].leaves)};
    BvhNode<W>* next = bvh.nodes.data() + bases[number].node;
    for (BvhNode<W> node : part.nodes) {
      for (std::uint32_t& child : node.child) {
        if (child != kBvhNoChild) child = bases[number].moved(child);
      }
      *next++ = node;
    }
    if (part.leaves != nullptr) set.leaves.move_in(*part.leaves);
  });
  return bases;
}

}  // namespace tessera::core
