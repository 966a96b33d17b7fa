// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/kd_index.h"

#include <new>
#include <string>
#include <utility>

namespace tessera::core {
namespace {

KdIndex make_index(const KdTree& tree, std::uint32_t block_size, LeafWriter& leaves) {
  KdIndex index;
  if (tree.primitive_refs().empty()) return index;
  index.bounds = tree.bounds();
  index.nodes.assign(tree.nodes().begin(), tree.nodes().end());
  std::size_t block_count = 0;
  for (const KdNode& node : index.nodes) {
    if ((node.tag_and_index & 3u) == kKdLeafTag)
      block_count += (node.count + block_size - 1) / block_size;
  }
  leaves.reserve(block_count);
  for (KdNode& node : index.nodes) {
    if ((node.tag_and_index & 3u) != kKdLeafTag) continue;
    const LeafRange leaf =
        leaves.append(tree.primitive_refs().subspan(node.tag_and_index >> 2, node.count));
    node.tag_and_index = leaf.first << 2 | kKdLeafTag;
    node.count = leaf.count;
  }
  return index;
}

}  // namespace

Result<KdIndex> build_kd_index(const PrimitiveSet& set, const BuildControl& control,
                               const KdBuildConfig& config) {
  const Result<KdTree> tree = build_kd_tree(set.boxes, control, config);
  if (!tree.is_ok()) return tree.status();
  try {
    return make_index(*tree, config.block_size, set.leaves);
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("no memory for the spatial index of " +
                                      std::to_string(set.boxes.size()) + " primitives");
  }
}

}  // namespace tessera::core
