// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/bvh_fast_builder.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "slave/core/accel/bvh_join.h"
#include "slave/core/accel/grid_sort.h"
#include "slave/core/accel/run_tasks.h"
#include "slave/core/accel/sah_bins.h"
#include "slave/core/accel/task_crew.h"

namespace tessera::core {
namespace {

// A range of at most a kTaskShare-th of all references, or of kTaskRefsMin, is built by one task;
// that makes enough tasks to keep 16 threads busy.
constexpr std::uint32_t kTaskShare = 64;
constexpr std::uint32_t kTaskRefsMin = 4096;
// From this depth on ranges are halved, whatever their boxes. 23 more steps cut 2^30 primitives
// into leaves of 16 blocks of 8, and 32 + 23 is less than kBvhDepthMax.
constexpr int kHalvingDepth = 32;
static_assert(kGridDepthMax <= kHalvingDepth);

// A range with the cut that would split it, or none where it is to be a leaf.
struct Branch {
  RefRange range;
  SahCut cut{};
  std::int32_t of_grid = -1;  // the range of the grid that it is, if that one is split
  bool is_leaf = true;
  int depth = 0;  // below the root, in halvings
};

// A part of the hierarchy that one task builds.
template <int W>
struct Part : BvhPart<W> {
  Branch root{};
  std::uint32_t parent = 0;  // node of the first part
  int slot = 0;
};

template <int W>
class Builder {
 public:
  // Moves the references of `sorted` around.
  Builder(GridSorted& sorted, const PrimitiveSet& set, const BuildControl& control)
      : ranges_(sorted.ranges),
        refs_(sorted.references.refs.data(), sorted.references.all.size()),
        leaves_(set.leaves),
        control_(control),
        task_refs_(std::max(kTaskRefsMin, sorted.references.all.size() / kTaskShare)) {}

  bool is_cancelled() const { return control_.is_to_stop(); }

  // Returns: the parts, that with the root first.
  std::vector<Part<W>> run() {
    std::vector<Part<W>> parts(1);
    SahBins bins;
    parts[0].leaves = leaves_.fresh();
    parts[0].root = branch_of_grid(0, 0, bins);
    std::vector<Part<W>> below;
    build_node(parts[0].root, bins, parts[0], &below);
    for (Part<W>& part : below) make_room<W>(leaves_, part.root.range.size() / W * 7 / 4 + 1, part);
    run_tasks(static_cast<int>(below.size()), control_.thread_count, [&](int i) {
      Part<W>& part = below[static_cast<std::size_t>(i)];
      SahBins own;
      build_node(part.root, own, part, nullptr);
    });
    std::move(below.begin(), below.end(), std::back_inserter(parts));
    return parts;
  }

 private:
  Branch branch_of(const RefRange& range, int depth, SahBins& bins) const {
    Branch branch{range, {}, -1, true, depth};
    if (range.size() <= W) return branch;
    if (depth < kHalvingDepth) branch.cut = bins.cut_longest(refs_, range, W);
    const float area = range.bounds.half_area();
    const bool may_be_leaf = range.size() <= W * kBvhLeafBlocksMax;
    const float as_leaf = area * blocks_of(range.size(), W);
    const float as_node = area + branch.cut.cost;
    branch.is_leaf = may_be_leaf && (branch.cut.axis < 0 || as_leaf <= as_node);
    return branch;
  }
  Branch branch_of_grid(std::uint32_t index, int depth, SahBins& bins) const {
    const GridRange& at = ranges_[index];
    if (at.left == 0) return branch_of(at.range, depth, bins);
    return {at.range, {}, static_cast<std::int32_t>(index), false, depth};
  }
  std::pair<Branch, Branch> halves_of(const Branch& branch, SahBins& bins) const {
    const int depth = branch.depth + 1;
    if (branch.of_grid >= 0) {
      const GridRange& at = ranges_[static_cast<std::size_t>(branch.of_grid)];
      return {branch_of_grid(at.left, depth, bins), branch_of_grid(at.right, depth, bins)};
    }
    const auto [left, right] = SahBins::split(refs_, branch.range, branch.cut);
    return {branch_of(left, depth, bins), branch_of(right, depth, bins)};
  }

  // Fills a node with up to W children of `root`; recursion is bounded by kBvhDepthMax. `below`
  // takes large subtrees that are not built here; null: all are built here.
  std::uint32_t build_node(const Branch& root, SahBins& bins, Part<W>& out,
                           std::vector<Part<W>>* below) const {
    const auto index = static_cast<std::uint32_t>(out.nodes.size());
    out.nodes.emplace_back();
    Branch children[W];
    children[0] = root;
    int count = 1;
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
      auto [left, right] = halves_of(children[widest], bins);
      children[widest] = left;
      children[count++] = right;
    }
    for (int i = 0; i < W; ++i) {
      std::uint32_t reference = kBvhNoChild;
      if (i < count && !is_cancelled()) {
        if (children[i].is_leaf) {
          reference = make_leaf(children[i].range, out);
        } else if (below != nullptr && children[i].range.size() <= task_refs_) {
          below->push_back({{}, children[i], index, i});
        } else {
          reference = build_node(children[i], bins, out, below);
        }
      }
      set_child(out.nodes[index], i, i < count ? children[i].range.bounds : Box4(), reference);
    }
    return index;
  }

  static void set_child(BvhNode<W>& node, int slot, const Box4& box, std::uint32_t reference) {
    for (int a = 0; a < 3; ++a) {
      node.lower[a][slot] = box.lower[a];
      node.upper[a][slot] = box.upper[a];
    }
    node.child[slot] = reference;
  }

  std::uint32_t make_leaf(const RefRange& range, Part<W>& out) const {
    std::uint32_t primitives[W * kBvhLeafBlocksMax];
    std::uint32_t* const end =
        std::transform(refs_.begin() + range.begin, refs_.begin() + range.end, primitives,
                       [](const PrimitiveRef& ref) { return ref.primitive; });
    std::sort(primitives, end);
    const LeafRange leaf = out.leaves->append({primitives, end});
    return bvh_leaf_of(leaf.first, leaf.count);
  }

  const std::span<const GridRange> ranges_;
  const std::span<PrimitiveRef> refs_;
  const LeafWriter& leaves_;
  const BuildControl& control_;
  const std::uint32_t task_refs_;
};

template <int W>
Result<Bvh<W>> build(const PrimitiveSet& set, const BuildControl& control) {
  GridSorted sorted = grid_sort(set.boxes, W, control.thread_count);
  Bvh<W> bvh;
  if (sorted.ranges.empty()) return bvh;
  bvh.bounds = sorted.references.all.bounds.bounds();
  Builder<W> builder(sorted, set, control);
  std::vector<Part<W>> parts = builder.run();
  if (builder.is_cancelled())
    return Status::cancelled("the build of the spatial index was cancelled");
  Result<std::vector<PartBase>> bases =
      join_parts(std::span(parts), set, control.thread_count, bvh);
  if (!bases.is_ok()) return bases.status();
  for (std::size_t i = 1; i < parts.size(); ++i)
    bvh.nodes[parts[i].parent].child[parts[i].slot] = (*bases)[i].node;
  return bvh;
}

}  // namespace

template <int W>
Result<Bvh<W>> build_bvh_fast(const PrimitiveSet& set, const BuildControl& control) {
  TESSERA_CHECK_GE(set.alone_from, set.boxes.size());
  try {
    const TaskCrew crew;
    return build<W>(set, control);
  } catch (const std::bad_alloc&) {
    return Status::resource_exhausted("no memory for the spatial index of " +
                                      std::to_string(set.boxes.size()) + " primitives");
  }
}

template Result<Bvh<8>> build_bvh_fast<8>(const PrimitiveSet&, const BuildControl&);
template Result<Bvh<16>> build_bvh_fast<16>(const PrimitiveSet&, const BuildControl&);

}  // namespace tessera::core
