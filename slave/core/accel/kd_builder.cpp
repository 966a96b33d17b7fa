// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/kd_builder.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "slave/core/accel/run_tasks.h"
#include "slave/core/accel/sah_split.h"

namespace tessera::core {
namespace {

// A voxel of at most this many primitives, or at this depth, is built whole by one task. That makes
// enough tasks to keep 16 threads busy.
constexpr std::size_t kTaskRefsMax = 8192;
constexpr int kTaskDepth = 7;

void set_axis(Vec3f& v, int axis, float value) {
  (axis == 0 ? v.x : axis == 1 ? v.y : v.z) = value;
}

struct Voxel {
  Bounds3f bounds;
  std::vector<std::uint32_t> refs;
  std::vector<Bounds3f> parts;  // boxes of the primitives' parts; empty without a clipper
  std::uint64_t budget = 0;  // entries that the leaves below may have in all; at least refs.size()
  int depth = 0;
};

// A finished part of the tree; indices count from its own first node and entry.
struct Fragment {
  std::vector<KdNode> nodes;
  std::vector<std::uint32_t> refs;
};

struct Shared {
  std::span<const Bounds3f> boxes;
  const KdBuildConfig& config;
  const BuildControl& control;
  int depth_max;

  bool cancelled() const { return control.is_to_stop(); }
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
  node.count = static_cast<std::uint32_t>(voxel.refs.size());
  out.nodes[slot] = node;
  out.refs.insert(out.refs.end(), voxel.refs.begin(), voxel.refs.end());
}

// Adds to one half of a split the part that lies in it of a primitive that is in both halves.
void add_part(const Shared& shared, std::uint32_t primitive, const Bounds3f& box, Voxel& voxel) {
  const Bounds3f part = shared.config.clipper->clip(primitive, voxel.bounds);
  const Bounds3f cut{max(part.lower, box.lower), min(part.upper, box.upper)};
  if (cut.is_empty()) return;
  voxel.refs.push_back(primitive);
  voxel.parts.push_back(cut);
}

// Hands the primitives of a voxel down to its halves. boxes: those of the primitives, or of their
// parts. Returns: false, with the children untouched, where the voxel should be a leaf.
template <class Boxes>
bool split_by(const Shared& shared, const Boxes& boxes, const Voxel& voxel, SahScratch& scratch,
              SahSplit& split, Voxel (&child)[2]) {
  constexpr bool kCuts = std::is_same_v<Boxes, PartBoxes>;
  split = choose_split(boxes, voxel.bounds, shared.config, scratch);
  if (split.axis < 0) return false;
  const int axis = split.axis;
  const float plane = split.plane;
  std::size_t count[2] = {0, 0};
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const float lower = boxes[i].lower[axis], upper = boxes[i].upper[axis];
    count[0] += goes_below(lower, plane, upper) ? 1u : 0u;
    count[1] += goes_above(plane, upper) ? 1u : 0u;
  }
  if (count[0] + count[1] > voxel.budget) return false;
  for (int side = 0; side < 2; ++side) {
    child[side] = {voxel.bounds, {}, {}, 0, voxel.depth + 1};
    child[side].refs.reserve(count[side]);
    if (kCuts) child[side].parts.reserve(count[side]);
  }
  set_axis(child[0].bounds.upper, axis, plane);
  set_axis(child[1].bounds.lower, axis, plane);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const float lower = boxes[i].lower[axis], upper = boxes[i].upper[axis];
    const bool is_there[2] = {goes_below(lower, plane, upper), goes_above(plane, upper)};
    for (int side = 0; side < 2; ++side) {
      if (!is_there[side]) continue;
      if (kCuts && is_there[1 - side]) {
        add_part(shared, voxel.refs[i], boxes[i], child[side]);
        continue;
      }
      child[side].refs.push_back(voxel.refs[i]);
      if (kCuts) child[side].parts.push_back(boxes[i]);
    }
  }
  return true;
}

// Splits the voxel in two. Returns false, with the children untouched, when it should be a leaf.
bool split_voxel(const Shared& shared, Voxel& voxel, SahScratch& scratch, SahSplit& split,
                 Voxel (&child)[2]) {
  if (voxel.depth >= shared.depth_max) return false;
  const bool is_split = shared.config.clipper != nullptr
                            ? split_by(shared, PartBoxes(voxel.parts), voxel, scratch, split, child)
                            : split_by(shared, WholeBoxes{shared.boxes.data(), voxel.refs}, voxel,
                                       scratch, split, child);
  if (!is_split) return false;
  const std::uint64_t spare = voxel.budget - (child[0].refs.size() + child[1].refs.size());
  const std::uint64_t n0 = child[0].refs.size(), n1 = child[1].refs.size();
  const std::uint64_t spare0 = n0 + n1 == 0 ? 0 : spare / (n0 + n1) * n0;
  child[0].budget = n0 + spare0;
  child[1].budget = n1 + (spare - spare0);
  voxel.parts = {};
  voxel.refs = {};  // free before the children are built: memory stays O(n) per level of depth
  return true;
}

// Recursion is bounded by depth_max <= kKdDepthMax.
void build_subtree(const Shared& shared, Voxel voxel, std::size_t slot, SahScratch& scratch,
                   Fragment& out) {
  if (voxel.refs.size() > 256 && shared.cancelled()) return;
  SahSplit split;
  Voxel child[2];
  if (!split_voxel(shared, voxel, scratch, split, child)) {
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
  std::size_t child = 0;  // task of the lower half; the upper's is next. 0: built whole, or a leaf
  Fragment result;
};

struct Halves {
  Voxel voxel[2];
};

// Splits large parts in rounds, so that threads have work from the first halves on.
std::vector<Task> run_rounds(const Shared& shared, Voxel root, int thread_count) {
  std::vector<Task> tasks(1);
  tasks[0].voxel = std::move(root);
  for (std::size_t first = 0; first < tasks.size();) {
    const std::size_t count = tasks.size() - first;
    std::vector<Halves> halves(count);
    run_tasks(static_cast<int>(count), thread_count, [&](int i) {
      Task& task = tasks[first + static_cast<std::size_t>(i)];
      auto& half = halves[static_cast<std::size_t>(i)];
      SahScratch scratch;
      const bool is_small =
          task.voxel.refs.size() <= kTaskRefsMax || task.voxel.depth >= kTaskDepth;
      if (!is_small && split_voxel(shared, task.voxel, scratch, task.split, half.voxel)) return;
      task.result.nodes.resize(1);
      build_subtree(shared, std::move(task.voxel), 0, scratch, task.result);
    });
    for (std::size_t i = 0; i < count; ++i) {
      if (!tasks[first + i].result.nodes.empty()) continue;
      tasks[first + i].child = tasks.size();
      for (Voxel& half : halves[i].voxel) tasks.emplace_back().voxel = std::move(half);
    }
    first += count;
  }
  return tasks;
}

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

// Recursion is bounded by kTaskDepth.
void place(std::vector<Task>& tasks, std::size_t number, std::size_t slot, Fragment& top) {
  Task& task = tasks[number];
  if (task.child == 0) {
    append(top, slot, task.result);
    task.result = {};
    return;
  }
  const std::size_t first = top.nodes.size();
  top.nodes.resize(first + 2);
  top.nodes[slot] = inner_node(task.split.axis, task.split.plane, first);
  place(tasks, task.child, first, top);
  place(tasks, task.child + 1, first + 1, top);
}

Result<KdTree> build(std::span<const Bounds3f> boxes, const BuildControl& control,
                     const KdBuildConfig& config) {
  Voxel root;
  for (std::size_t p = 0; p < boxes.size(); ++p) {
    if (boxes[p].is_empty()) continue;
    root.bounds.grow(boxes[p]);
    root.refs.push_back(static_cast<std::uint32_t>(p));
    if (config.clipper != nullptr) root.parts.push_back(boxes[p]);
  }
  if (root.refs.empty()) return KdTree();
  const Bounds3f bounds = root.bounds;
  root.budget = std::uint64_t{config.refs_per_primitive_max} * root.refs.size() + 64;
  const double log2_count = std::log2(static_cast<double>(root.refs.size()));
  Shared shared{boxes, config, control,
                std::min(kKdDepthMax, static_cast<int>(8 + 1.3 * log2_count))};
  std::vector<Task> tasks = run_rounds(shared, std::move(root), control.thread_count);
  if (shared.cancelled()) return Status::cancelled("the build of the spatial index was cancelled");
  std::uint64_t node_count = 1, ref_count = 0;
  for (const Task& task : tasks) {
    node_count += task.child == 0 ? task.result.nodes.size() - 1 : 2;
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
  place(tasks, 0, 0, top);
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
    return build(boxes, control, config);
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("no memory for the spatial index of " +
                                      std::to_string(boxes.size()) + " primitives");
  }
}

}  // namespace tessera::core
