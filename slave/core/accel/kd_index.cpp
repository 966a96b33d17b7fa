// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/kd_index.h"

#include <cstddef>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "common/base/work_gate.h"
#include "slave/core/accel/run_tasks.h"
#include "slave/core/accel/task_crew.h"

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

// Leaves are written in runs of about so many primitives each, by a task a run.
constexpr std::size_t kRunRefs = 16384;

// A run of leaves. Numbers count from its own first block and box.
template <int W>
struct Run {
  std::vector<std::uint32_t> leaves{};  // nodes of the tree
  std::size_t ref_count = 0;
  BvhNodes<W> boxes{};
  std::unique_ptr<LeafWriter> blocks{};
};

template <int W>
class IndexMaker {
 public:
  IndexMaker(const KdTree& tree, const PrimitiveSet& set, int thread_count)
      : tree_(tree), set_(set), thread_count_(thread_count) {}

  KdIndex<W> make() {
    if (tree_.primitive_refs().empty()) return {};
    index_.bounds = tree_.bounds();
    index_.nodes.assign(tree_.nodes().begin(), tree_.nodes().end());
    find_voxels();
    for_runs([this](std::size_t i) {
      Run<W> run = std::move(runs_[i]);  // neighbours in `runs_` share lines of the cache
      write(run);
      runs_[i] = std::move(run);
    });
    join();
    return std::move(index_);
  }

 private:
  template <typename Work>
  void for_runs(const Work& work) {
    run_tasks(static_cast<int>(runs_.size()), thread_count_, [&work](int i) {
      give_way();
      work(static_cast<std::size_t>(i));
    });
  }

  // Finds the voxels of nodes, and parts leaves into runs. Children lie behind their node.
  void find_voxels() {
    voxels_.resize(index_.nodes.size());
    voxels_[0] = tree_.bounds();
    for (std::size_t n = 0; n < index_.nodes.size(); ++n) {
      const KdNode node = index_.nodes[n];
      const std::uint32_t axis = node.tag_and_index & 3u, child = node.tag_and_index >> 2;
      if (axis == kKdLeafTag) {
        if (runs_.empty() || runs_.back().ref_count >= kRunRefs) runs_.emplace_back();
        runs_.back().leaves.push_back(static_cast<std::uint32_t>(n));
        runs_.back().ref_count += node.count;
        continue;
      }
      voxels_[child] = voxels_[child + 1] = voxels_[n];
      set_axis(voxels_[child].upper, axis, node.split);
      set_axis(voxels_[child + 1].lower, axis, node.split);
    }
  }

  void write(Run<W>& run) {
    run.blocks = set_.leaves.fresh();
    run.blocks->reserve(run.ref_count / W + run.leaves.size());
    run.boxes.reserve(run.ref_count / (W * W) + run.leaves.size());
    for (const std::uint32_t n : run.leaves) write_leaf(run, n);
  }

  void write_leaf(Run<W>& run, std::uint32_t n) {
    KdNode& node = index_.nodes[n];
    const LeafRange range =
        run.blocks->append(tree_.primitive_refs().subspan(node.tag_and_index >> 2, node.count));
    node.tag_and_index = static_cast<std::uint32_t>(run.boxes.size()) << 2 | kKdLeafTag;
    node.count = (range.count + W - 1) / W;
    for (std::uint32_t first = 0; first < range.count; first += W) {
      BvhNode<W>& boxes = run.boxes.emplace_back();
      for (std::uint32_t i = 0; i < W; ++i) {
        const bool is_used = first + i < range.count;
        const std::uint32_t block = range.first + first + i;
        set_child(boxes, i, is_used ? box_of(*run.blocks, block, voxels_[n]) : Bounds3f{},
                  is_used ? block : kBvhNoChild);
      }
    }
  }

  // What a ray meets of a primitive outside of the voxel, it meets in another leaf.
  Bounds3f box_of(const LeafWriter& blocks, std::uint32_t block, const Bounds3f& voxel) const {
    Bounds3f box;
    for (const std::uint32_t primitive : blocks.primitives_of(block))
      box.grow(set_.boxes[primitive]);
    return {max(box.lower, voxel.lower), min(box.upper, voxel.upper)};
  }

  void join() {
    std::vector<LeafWriter*> writers;
    std::vector<std::uint32_t> first_boxes;
    std::size_t box_count = 0;
    for (const Run<W>& run : runs_) {
      writers.push_back(run.blocks.get());
      first_boxes.push_back(static_cast<std::uint32_t>(box_count));
      box_count += run.boxes.size();
    }
    const std::vector<std::uint32_t> first_blocks = set_.leaves.make_room(writers);
    index_.leaves.resize(box_count);
    for_runs([&](std::size_t i) {
      const Run<W> run = std::move(runs_[i]);
      BvhNode<W>* next = index_.leaves.data() + first_boxes[i];
      for (BvhNode<W> boxes : run.boxes) {
        for (std::uint32_t& block : boxes.child) {
          if (block != kBvhNoChild) block += first_blocks[i];
        }
        *next++ = boxes;
      }
      for (const std::uint32_t n : run.leaves) index_.nodes[n].tag_and_index += first_boxes[i] << 2;
      set_.leaves.move_in(*run.blocks);
    });
  }

  const KdTree& tree_;
  const PrimitiveSet& set_;
  const int thread_count_;
  std::vector<Bounds3f> voxels_;  // of the tree's nodes
  std::vector<Run<W>> runs_;
  KdIndex<W> index_;
};

}  // namespace

template <int W>
Result<KdIndex<W>> build_kd_index(const PrimitiveSet& set, const BuildControl& control,
                                  const KdBuildConfig& config) {
  const TaskCrew crew;
  const Result<KdTree> tree = build_kd_tree(set.boxes, control, config);
  if (!tree.is_ok()) return tree.status();
  try {
    return IndexMaker<W>(*tree, set, control.thread_count).make();
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
