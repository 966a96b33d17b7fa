// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/bvh_builder.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "slave/core/accel/bvh_children.h"
#include "slave/core/accel/primitive_refs.h"
#include "slave/core/accel/run_tasks.h"
#include "slave/core/accel/sah_bins.h"
#include "slave/core/accel/spatial_split.h"

namespace tessera::core {
namespace {

// Ranges at the top of the tree are split first, each a task that makes tasks of its halves:
// whether a range becomes a node or a part of its parent's, its halves are the same. Then the top
// is built node by node in rounds, each node a task, from what is split. A range of at most a
// kTaskShare-th of all references, or of kTaskRefsMin, is built whole by one task; that makes
// enough tasks to keep 16 threads busy. A range of fewer than kTaskRefsLeast references is built by
// the task of its parent.
constexpr std::uint32_t kTaskShare = 64;
constexpr std::uint32_t kTaskRefsMin = 4096, kTaskRefsLeast = 512;
// From this depth on ranges are halved, whatever their boxes. 23 more steps cut 2^30 primitives
// into leaves of 16 blocks of 8, and 32 + 23 is less than kBvhDepthMax.
constexpr int kHalvingDepth = 32;

template <int W>
struct Fragment {
  std::vector<BvhNode<W>> nodes;
  std::unique_ptr<LeafWriter> leaves;
};

struct Halves;

// A range with the cut that would split it, or none where it is to be a leaf.
struct Child {
  RefRange range;
  SahCut cut;
  bool is_leaf = true;
  SpatialCut in_space{};           // with an axis: takes the place of `cut`
  const Halves* halves = nullptr;  // of a range that is split already

  bool is_cut() const { return cut.axis >= 0 || in_space.axis >= 0; }
  float cost() const { return in_space.axis >= 0 ? in_space.cost : cut.cost; }
};

struct Halves {
  Child left, right;
};

template <int W>
class Builder {
 public:
  struct Task {
    Child child;
    int depth = 0;
    std::size_t parent_task = 0;
    std::uint32_t parent = 0;  // node of the parent task's result
    int slot = 0;
    Fragment<W> result{};
    std::vector<Task> spawned{};
  };

  Builder(std::span<PrimitiveRef> refs, const RefRange& all, const PrimitiveSet& set,
          const BuildControl& control, const BvhBuildConfig& config)
      : refs_(refs),
        leaves_(set.leaves),
        control_(control),
        config_(config),
        alone_from_(set.alone_from),
        block_size_(set.alone_from < set.boxes.size() ? 1 : W),
        counted_by_(config.counts_primitives ? 1 : block_size_),
        counted_blocks_(static_cast<float>(counted_by_) / static_cast<float>(block_size_)),
        task_refs_(std::max(kTaskRefsMin, all.size() / kTaskShare)),
        overlap_min_(config.overlap_min * all.bounds.half_area()) {}

  bool is_cancelled() const {
    return control_.is_cancelled != nullptr &&
           control_.is_cancelled->load(std::memory_order_relaxed);
  }

  Child child_of(const RefRange& range, int depth, SahBins& bins) const {
    Child child{range, {}, true};
    const bool may_be_leaf = range.size() <= W * kBvhLeafBlocksMax && !has_to_split(range);
    if (range.size() <= W && may_be_leaf) return child;
    if (depth < kHalvingDepth) {
      child.cut = bins.cut(refs_, range, counted_by_);
      cut_in_space(child);
    }
    const float area = range.bounds.half_area();
    const auto block_count = (range.size() + block_size_ - 1) / block_size_;
    const auto blocks = static_cast<float>(block_count);
    const float as_leaf = config_.cost_block * area * blocks;
    const float as_node =
        config_.cost_node * area + config_.cost_block * child.cost() * counted_blocks_;
    child.is_leaf = may_be_leaf && (!child.is_cut() || as_leaf <= as_node);
    return child;
  }

  // Splits the large ranges below `root`. Returns: where their halves are kept.
  std::deque<Halves> split_top(Child& root, int thread_count) const {
    std::deque<Halves> all;
    std::mutex mutex;  // of `all`
    struct Item {
      Child* child;
      int depth;
    };
    const auto is_large = [this](const Item& item) {
      return !item.child->is_leaf && item.child->range.size() > task_refs_ &&
             item.depth < kHalvingDepth && !is_cancelled();
    };
    if (!is_large({&root, 0})) return all;
    run_growing(Item{&root, 0}, thread_count, [&](const Item& item, const auto& put) {
      SahBins bins;
      const auto [left, right] = halves_of(*item.child);
      std::unique_lock lock(mutex);
      Halves& halves = all.emplace_back();
      lock.unlock();
      item.child->halves = &halves;
      halves.left = child_of(left, item.depth, bins);
      const Item below[] = {{&halves.left, item.depth + 1}, {&halves.right, item.depth + 1}};
      if (is_large(below[0])) put(below[0]);
      halves.right = child_of(right, item.depth, bins);
      if (is_large(below[1])) put(below[1]);
    });
    return all;
  }

  void run(Task& task) const {
    SahBins bins;
    task.result.leaves = leaves_.fresh();
    const bool is_whole = task.child.range.size() <= task_refs_;
    if (is_whole) {
      // A good guess saves most of the moves of a growing array.
      const std::size_t blocks = task.child.range.size() / W * 5 / 4 + 1;
      task.result.leaves->reserve(blocks);
      task.result.nodes.reserve(blocks / (W / 2) + 1);
    }
    build_node(task.child, task.depth, bins, task.result, is_whole ? nullptr : &task.spawned);
  }

  // Fills a node with up to W children of `root`; recursion is bounded by kBvhDepthMax. `tasks`
  // takes large subtrees that are not built here; null: all are built here.
  std::uint32_t build_node(const Child& root, int depth, SahBins& bins, Fragment<W>& out,
                           std::vector<Task>* tasks) const {
    const auto index = static_cast<std::uint32_t>(out.nodes.size());
    out.nodes.emplace_back();
    Child children[W];
    int count = 0;
    children[count++] = root;
    while (count < W) {
      int widest = -1;
      float widest_area = -1;
      for (int i = 0; i < count; ++i) {
        const float area = children[i].range.bounds.half_area();
        if (children[i].is_leaf || area <= widest_area) continue;
        widest = i;
        widest_area = area;
      }
      if (widest < 0) break;
      if (const Halves* const halves = children[widest].halves) {
        children[widest] = halves->left;
        children[count++] = halves->right;
        continue;
      }
      const auto [left, right] = halves_of(children[widest]);
      children[widest] = child_of(left, depth + 1, bins);
      children[count++] = child_of(right, depth + 1, bins);
    }
    for (int i = 0; i < W; ++i) {
      std::uint32_t reference = kBvhNoChild;
      if (i < count && !is_cancelled()) {
        if (children[i].is_leaf) {
          reference = make_leaf(children[i].range, out);
        } else if (tasks != nullptr && children[i].range.size() >= kTaskRefsLeast) {
          tasks->push_back({children[i], depth + 1, 0, index, i});
        } else {
          reference = build_node(children[i], depth + 1, bins, out, nullptr);
        }
      }
      set_child(out.nodes[index], i, i < count ? children[i].range.bounds : Box4(), reference);
    }
    return index;
  }

 private:
  // Cuts the child in space where that is cheaper.
  void cut_in_space(Child& child) const {
    if (config_.clipper == nullptr || child.range.room() == 0) return;
    const SahCut& cut = child.cut;
    Box4 shared = cut.left;
    shared.shrink(cut.right);
    if (cut.axis >= 0 && !(shared.half_area() > overlap_min_)) return;
    SpatialSplitter splitter(*config_.clipper);
    const SpatialCut in_space = splitter.cut(refs_, child.range, counted_by_);
    const bool is_cheaper = cut.axis < 0 || config_.cut_weight * in_space.cost < cut.cost;
    if (in_space.axis >= 0 && is_cheaper) child.in_space = in_space;
  }

  std::pair<RefRange, RefRange> halves_of(const Child& child) const {
    if (child.in_space.axis < 0) return SahBins::split(refs_, child.range, child.cut);
    return SpatialSplitter(*config_.clipper).split(refs_, child.range, child.in_space);
  }

  // Whether a primitive of the range takes a leaf of its own and is not alone.
  bool has_to_split(const RefRange& range) const {
    if (block_size_ == W || range.size() == 1) return false;
    const auto refs = refs_.subspan(range.begin, range.size());
    return std::any_of(refs.begin(), refs.end(),
                       [this](const PrimitiveRef& ref) { return ref.primitive >= alone_from_; });
  }

  static void set_child(BvhNode<W>& node, int slot, const Box4& box, std::uint32_t reference) {
    for (int a = 0; a < 3; ++a) {
      node.lower[a][slot] = box.lower[a];
      node.upper[a][slot] = box.upper[a];
    }
    node.child[slot] = reference;
  }

  std::uint32_t make_leaf(const RefRange& range, Fragment<W>& out) const {
    const auto first = refs_.begin() + range.begin, last = refs_.begin() + range.end;
    std::sort(first, last, [](const PrimitiveRef& a, const PrimitiveRef& b) {
      return a.primitive < b.primitive;
    });
    std::uint32_t primitives[W * kBvhLeafBlocksMax];
    std::transform(first, last, primitives, [](const PrimitiveRef& ref) { return ref.primitive; });
    const LeafRange leaf = out.leaves->append({primitives, range.size()});
    return bvh_leaf_of(leaf.first, leaf.count);
  }

  std::span<PrimitiveRef> refs_;
  const LeafWriter& leaves_;
  const BuildControl& control_;
  const BvhBuildConfig& config_;
  const std::uint32_t alone_from_;
  const std::uint32_t block_size_;  // 1 where some primitives take a leaf each
  const std::uint32_t counted_by_;  // primitives in what splits count
  const float counted_blocks_;      // blocks in what splits count
  const std::uint32_t task_refs_;
  const float overlap_min_;
};

// Appends a task's result and ties it to the slot that its parent kept for it. Returns: the number
// of its first node.
template <int W>
std::uint32_t append(const typename Builder<W>::Task& task, std::uint32_t parent_base, Bvh<W>& top,
                     LeafWriter& leaves) {
  const auto node_base = static_cast<std::uint32_t>(top.nodes.size());
  const std::uint32_t block_base = leaves.join(*task.result.leaves);
  for (BvhNode<W> node : task.result.nodes) {
    for (std::uint32_t& child : node.child) {
      if (child != kBvhNoChild) child += (child & kBvhLeaf) != 0 ? block_base : node_base;
    }
    top.nodes.push_back(node);
  }
  if (node_base != 0) top.nodes[parent_base + task.parent].child[task.slot] = node_base;
  return node_base;
}

// Runs all tasks. Returns: them, parents in front of the tasks that they have spawned.
template <int W>
std::vector<typename Builder<W>::Task> run_rounds(const Builder<W>& builder, const RefRange& all,
                                                  int thread_count) {
  using Task = typename Builder<W>::Task;
  std::vector<Task> done, round(1);
  SahBins bins;
  round[0].child = builder.child_of(all, 0, bins);
  const std::deque<Halves> top = builder.split_top(round[0].child, thread_count);
  while (!round.empty()) {
    run_tasks(static_cast<int>(round.size()), thread_count,
              [&](int i) { builder.run(round[static_cast<std::size_t>(i)]); });
    std::vector<Task> next;
    for (Task& task : round) {
      for (Task& child : task.spawned) {
        child.parent_task = done.size();
        next.push_back(std::move(child));
      }
      task.spawned.clear();
      done.push_back(std::move(task));
    }
    round = std::move(next);
  }
  return done;
}

template <int W>
Result<Bvh<W>> build(const PrimitiveSet& set, const BuildControl& control,
                     const BvhBuildConfig& config) {
  const float cuts_max = config.clipper != nullptr ? config.cuts_max : 0;
  const References references = refer_to(set.boxes, cuts_max, control.thread_count);
  const RefRange& all = references.all;
  Bvh<W> bvh;
  if (all.size() == 0) return bvh;
  bvh.bounds = all.bounds.bounds();
  const std::span<PrimitiveRef> refs(references.refs.get(), all.limit);
  const Builder<W> builder(refs, all, set, control, config);
  auto tasks = run_rounds(builder, all, control.thread_count);
  if (builder.is_cancelled())
    return Status::cancelled("the build of the spatial index was cancelled");
  std::size_t node_count = 0, block_count = 0;
  for (const auto& task : tasks) {
    node_count += task.result.nodes.size();
    block_count += task.result.leaves->block_count();
  }
  if (block_count > kBvhBlockMask) {
    return Status::resource_exhausted("the spatial index of " + std::to_string(set.boxes.size()) +
                                      " primitives has more than 2^27 blocks: split the scene");
  }
  bvh.nodes.reserve(node_count);
  set.leaves.reserve(block_count);
  std::vector<std::uint32_t> bases;
  for (auto& task : tasks) {
    const std::uint32_t parent_base = bases.empty() ? 0 : bases[task.parent_task];
    bases.push_back(append<W>(task, parent_base, bvh, set.leaves));
    task.result = {};
  }
  return bvh;
}

}  // namespace

BvhBuildConfig spatial_build(const PrimitiveClipper& clipper) {
  BvhBuildConfig config;
  config.clipper = &clipper;
  config.counts_primitives = true;
  return config;
}

template <int W>
Result<Bvh<W>> build_bvh(const PrimitiveSet& set, const BuildControl& control,
                         const BvhBuildConfig& config) {
  try {
    return build<W>(set, control, config);
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("no memory for the spatial index of " +
                                      std::to_string(set.boxes.size()) + " primitives");
  }
}

template Result<Bvh<8>> build_bvh<8>(const PrimitiveSet&, const BuildControl&,
                                     const BvhBuildConfig&);
template Result<Bvh<16>> build_bvh<16>(const PrimitiveSet&, const BuildControl&,
                                       const BvhBuildConfig&);

}  // namespace tessera::core
