// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/kd_builder.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "slave/core/accel/kd_voxel.h"
#include "slave/core/accel/run_tasks.h"
#include "slave/core/accel/sah_split.h"
#include "slave/core/accel/task_crew.h"

namespace tessera::core {
namespace {

// A voxel of at most this many primitives, or at this depth, is built whole by one task. That makes
// enough tasks to keep 16 threads busy.
constexpr std::size_t kTaskRefsMax = 2048;
constexpr int kTaskDepth = 9;

// A finished part of the tree; indices count from its own first node and entry.
struct Fragment {
  std::vector<KdNode> nodes;
  std::vector<std::uint32_t> refs;
};

struct Shared {
  const VoxelSplitter& splitter;
  const BuildControl& control;
  int depth_max;

  bool cancelled() const { return control.is_to_stop(); }
  bool split(Voxel& voxel, SahScratch& scratch, SahSplit& split, Voxel (&child)[2]) const {
    return voxel.depth < depth_max && splitter.split(voxel, scratch, split, child);
  }
};

KdNode inner_node(int axis, float split, std::size_t child) {
  KdNode node;
  node.tag_and_index = static_cast<std::uint32_t>(child << 2) | static_cast<std::uint32_t>(axis);
  node.split = split;
  return node;
}

void make_leaf(const Voxel& voxel, std::size_t slot, Fragment& out) {
  KdNode node;
  node.tag_and_index = static_cast<std::uint32_t>(out.refs.size() << 2) | kKdLeafTag;
  node.count = static_cast<std::uint32_t>(voxel.size());
  out.nodes[slot] = node;
  out.refs.insert(out.refs.end(), voxel.content.refs.begin(), voxel.content.refs.end());
}

// Recursion is bounded by depth_max <= kKdDepthMax.
void build_subtree(const Shared& shared, Voxel voxel, std::size_t slot, SahScratch& scratch,
                   Fragment& out) {
  if (voxel.size() > 256 && shared.cancelled()) return;
  SahSplit split;
  Voxel child[2];
  if (!shared.split(voxel, scratch, split, child)) {
    make_leaf(voxel, slot, out);
    return;
  }
  const std::size_t first = out.nodes.size();
  out.nodes.resize(first + 2);
  out.nodes[slot] = inner_node(split.axis, split.plane, first);
  build_subtree(shared, std::move(child[0]), first, scratch, out);
  build_subtree(shared, std::move(child[1]), first + 1, scratch, out);
}

// A part of the tree. Either it is split once and its halves are tasks of their own, or it is built
// whole.
struct Task {
  Voxel voxel;
  SahSplit split;
  Task* halves[2] = {nullptr, nullptr};  // null: built whole, or a leaf
  Fragment result;
};

// Splits large parts until they are small enough to be one task's.
class Tasks {
 public:
  explicit Tasks(const Shared& shared) : shared_(shared) {}

  // Returns: the task of the whole tree; it lives as long as this.
  Task& run(Voxel root) {
    Task& first = all_.emplace_back();
    first.voxel = std::move(root);
    std::deque<Task*> waiting;
    share(first, waiting);
    run_growing(waiting, shared_.control.thread_count, [this](Task* task, const auto& put) {
      if (!split(*task)) return;
      for (Task* const half : task->halves) put(half);
    });
    return first;
  }
  const std::deque<Task>& all() const { return all_; }

 private:
  // Splits voxels that several threads split, one by one; hands out the others.
  void share(Task& task, std::deque<Task*>& waiting) {
    if (!shared_.splitter.is_shared(task.voxel) || shared_.cancelled()) {
      waiting.push_back(&task);
    } else if (split(task)) {
      for (Task* const half : task.halves) share(*half, waiting);
    }
  }

  // Returns: whether the task is split; otherwise it is built.
  bool split(Task& task) {
    SahScratch scratch;
    Voxel half[2];
    const bool is_deep = task.voxel.depth >= kTaskDepth && !shared_.splitter.is_shared(task.voxel);
    const bool is_small = task.voxel.size() <= kTaskRefsMax || is_deep;
    if (!is_small && !shared_.cancelled() && shared_.split(task.voxel, scratch, task.split, half)) {
      const std::lock_guard lock(mutex_);
      for (int side = 0; side < 2; ++side) {
        task.halves[side] = &all_.emplace_back();
        task.halves[side]->voxel = std::move(half[side]);
      }
      return true;
    }
    Fragment result;  // neighbouring tasks share lines of the cache
    result.nodes.resize(1);
    build_subtree(shared_, std::move(task.voxel), 0, scratch, result);
    task.result = std::move(result);
    return false;
  }

  const Shared& shared_;
  std::mutex mutex_;
  std::deque<Task> all_;  // guarded by the mutex, but for the elements
};

// Appends a subtree behind the top; its root takes the slot that the top kept for it.
void append(Fragment& top, std::size_t slot, const Fragment& part) {
  const std::size_t node_base = top.nodes.size() - 1;  // part's node 1 lands at the end of top
  const std::size_t ref_base = top.refs.size();
  const auto moved = [&](KdNode node) {
    const bool is_leaf = (node.tag_and_index & 3u) == kKdLeafTag;
    node.tag_and_index += static_cast<std::uint32_t>((is_leaf ? ref_base : node_base) << 2);
    return node;
  };
  top.nodes[slot] = moved(part.nodes[0]);
  for (std::size_t n = 1; n < part.nodes.size(); ++n) top.nodes.push_back(moved(part.nodes[n]));
  top.refs.insert(top.refs.end(), part.refs.begin(), part.refs.end());
}

// Recursion is bounded by depth_max <= kKdDepthMax.
void place(Task& task, std::size_t slot, Fragment& top) {
  if (task.halves[0] == nullptr) {
    append(top, slot, task.result);
    task.result = {};
    return;
  }
  const std::size_t first = top.nodes.size();
  top.nodes.resize(first + 2);
  top.nodes[slot] = inner_node(task.split.axis, task.split.plane, first);
  place(*task.halves[0], first, top);
  place(*task.halves[1], first + 1, top);
}

Result<KdTree> build(std::span<const Bounds3f> boxes, const BuildControl& control,
                     const KdBuildConfig& config) {
  const VoxelSplitter splitter(boxes, config, control.thread_count);
  Voxel root = splitter.root();
  if (root.size() == 0) return KdTree();
  const Bounds3f bounds = root.bounds;
  const double log2_count = std::log2(static_cast<double>(root.size()));
  const Shared shared{splitter, control,
                      std::min(kKdDepthMax, static_cast<int>(8 + 1.3 * log2_count))};
  Tasks tasks(shared);
  Task& whole = tasks.run(std::move(root));
  if (shared.cancelled()) return Status::cancelled("the build of the spatial index was cancelled");
  std::uint64_t node_count = 1, ref_count = 0;
  for (const Task& task : tasks.all()) {
    node_count += task.halves[0] == nullptr ? task.result.nodes.size() - 1 : 2;
    ref_count += task.result.refs.size();
  }
  if (node_count > kKdIndexMax || ref_count > kKdIndexMax) {
    return Status::resource_exhausted("the spatial index of " + std::to_string(boxes.size()) +
                                      " primitives has more than 2^30 entries: split the scene");
  }
  Fragment top;
  top.nodes.reserve(node_count);
  top.refs.reserve(ref_count);
  top.nodes.resize(1);
  place(whole, 0, top);
  return KdTree(bounds, std::move(top.nodes), std::move(top.refs));
}

}  // namespace

KdBuildConfig quality_build(const PrimitiveClipper& clipper) {
  KdBuildConfig config;
  config.sweep_max = 64;
  config.bin_count = kKdBinsMax;
  config.refine_min = 0;
  config.refine_share = 1;
  config.clipper = &clipper;
  return config;
}

Result<KdTree> build_kd_tree(std::span<const Bounds3f> boxes, const BuildControl& control,
                             const KdBuildConfig& config) {
  try {
    const TaskCrew crew;
    return build(boxes, control, config);
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("no memory for the spatial index of " +
                                      std::to_string(boxes.size()) + " primitives");
  }
}

}  // namespace tessera::core
