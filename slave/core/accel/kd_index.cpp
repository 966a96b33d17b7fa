#include "slave/core/accel/kd_index.h"

#include <algorithm>
#include <new>
#include <string>
#include <utility>

#include "slave/core/accel/kd_builder.h"
#include "slave/core/primitive/triangle/triangle_blocks.h"

namespace tessera::core {
namespace {

template <int W>
KdIndex<W> make_index(const KdTree& tree, std::span<const float> vertices) {
  KdIndex<W> index;
  if (tree.primitive_refs().empty()) return index;
  index.bounds = tree.bounds();
  index.nodes.assign(tree.nodes().begin(), tree.nodes().end());
  std::size_t block_count = 0;
  for (const KdNode& node : index.nodes) {
    if ((node.tag_and_index & 3u) == kKdLeafTag) block_count += (node.count + W - 1) / W;
  }
  index.blocks.reserve(block_count);
  for (KdNode& node : index.nodes) {
    if ((node.tag_and_index & 3u) != kKdLeafTag) continue;
    const std::span<const std::uint32_t> refs =
        tree.primitive_refs().subspan(node.tag_and_index >> 2, node.count);
    const auto first = static_cast<std::uint32_t>(index.blocks.size());
    append_blocks<W>(
        vertices, node.count, [&](std::uint32_t i) { return refs[i]; }, index.blocks);
    node.tag_and_index = first << 2 | kKdLeafTag;
    node.count = static_cast<std::uint32_t>(index.blocks.size()) - first;
  }
  return index;
}

}  // namespace

template <int W>
Result<KdIndex<W>> build_kd_index(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                  const BuildControl& control, KdBuildConfig config) {
  config.block_size = W;
  const Result<KdTree> tree = build_kd_tree(boxes, control, config);
  if (!tree.is_ok()) return tree.status();
  try {
    return make_index<W>(*tree, vertices);
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("no memory for the spatial index of " +
                                      std::to_string(boxes.size()) + " triangles");
  }
}

template Result<KdIndex<8>> build_kd_index<8>(std::span<const Bounds3f>, std::span<const float>,
                                              const BuildControl&, KdBuildConfig);
template Result<KdIndex<16>> build_kd_index<16>(std::span<const Bounds3f>, std::span<const float>,
                                                const BuildControl&, KdBuildConfig);

}  // namespace tessera::core
