// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/kd_index.h"

#include <new>
#include <string>
#include <utility>

namespace tessera::core {
namespace {

void set_axis(Vec3f& v, std::uint32_t axis, float value) {
  (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = value;
}

template <int W>
void set_child(BvhNode<W>& node, std::size_t slot, const Bounds3f& box, std::uint32_t block) {
  for (int a = 0; a < 3; ++a) {
    node.lower[a][slot] = box.lower[a];
    node.upper[a][slot] = box.upper[a];
  }
  node.child[slot] = block;
}

template <int W>
class IndexMaker {
 public:
  IndexMaker(const KdTree& tree, const PrimitiveSet& set) : tree_(tree), set_(set) {}

  KdIndex<W> make() {
    if (tree_.primitive_refs().empty()) return {};
    index_.bounds = tree_.bounds();
    index_.nodes.assign(tree_.nodes().begin(), tree_.nodes().end());
    std::size_t block_count = 0, box_count = 0;
    for (const KdNode& node : index_.nodes) {
      if ((node.tag_and_index & 3u) != kKdLeafTag) continue;
      const std::size_t blocks = (node.count + std::size_t{W} - 1) / W;
      block_count += blocks;
      box_count += (blocks + W - 1) / W;
    }
    set_.leaves.reserve(block_count);
    index_.leaves.reserve(box_count);
    std::vector<Bounds3f> voxels(index_.nodes.size());
    voxels[0] = tree_.bounds();
    // Children lie behind their node.
    for (std::size_t n = 0; n < index_.nodes.size(); ++n) {
      const KdNode node = index_.nodes[n];
      const std::uint32_t axis = node.tag_and_index & 3u, child = node.tag_and_index >> 2;
      if (axis == kKdLeafTag) {
        index_.nodes[n] = leaf_of(node, voxels[n]);
        continue;
      }
      voxels[child] = voxels[child + 1] = voxels[n];
      set_axis(voxels[child].upper, axis, node.split);
      set_axis(voxels[child + 1].lower, axis, node.split);
    }
    return std::move(index_);
  }

 private:
  KdNode leaf_of(const KdNode& node, const Bounds3f& voxel) {
    const LeafRange range =
        set_.leaves.append(tree_.primitive_refs().subspan(node.tag_and_index >> 2, node.count));
    KdNode leaf;
    leaf.tag_and_index = static_cast<std::uint32_t>(index_.leaves.size()) << 2 | kKdLeafTag;
    leaf.count = (range.count + W - 1) / W;
    for (std::uint32_t first = 0; first < range.count; first += W) {
      BvhNode<W>& boxes = index_.leaves.emplace_back();
      for (std::uint32_t i = 0; i < W; ++i) {
        const bool is_used = first + i < range.count;
        const std::uint32_t block = range.first + first + i;
        set_child(boxes, i, is_used ? box_of(block, voxel) : Bounds3f{},
                  is_used ? block : kBvhNoChild);
      }
    }
    return leaf;
  }

  // What a ray meets of a primitive outside of the voxel, it meets in another leaf.
  Bounds3f box_of(std::uint32_t block, const Bounds3f& voxel) const {
    Bounds3f box;
    for (const std::uint32_t primitive : set_.leaves.primitives_of(block))
      box.grow(set_.boxes[primitive]);
    return {max(box.lower, voxel.lower), min(box.upper, voxel.upper)};
  }

  const KdTree& tree_;
  const PrimitiveSet& set_;
  KdIndex<W> index_;
};

}  // namespace

template <int W>
Result<KdIndex<W>> build_kd_index(const PrimitiveSet& set, const BuildControl& control,
                                  const KdBuildConfig& config) {
  const Result<KdTree> tree = build_kd_tree(set.boxes, control, config);
  if (!tree.is_ok()) return tree.status();
  try {
    return IndexMaker<W>(*tree, set).make();
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("no memory for the spatial index of " +
                                      std::to_string(set.boxes.size()) + " primitives");
  }
}

template Result<KdIndex<8>> build_kd_index<8>(const PrimitiveSet&, const BuildControl&,
                                              const KdBuildConfig&);
template Result<KdIndex<16>> build_kd_index<16>(const PrimitiveSet&, const BuildControl&,
                                                const KdBuildConfig&);

}  // namespace tessera::core
