// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/range_splitter.h"

#include <algorithm>
#include <bit>

#include "slave/core/accel/bvh_layout.h"

namespace tessera::core {

RangeSplitter::RangeSplitter(std::span<PrimitiveRef> refs, const RefRange& all,
                             const PrimitiveSet& set, int width, std::uint32_t task_refs,
                             const BuildControl& control, const BvhBuildConfig& config)
    : refs_(refs),
      control_(control),
      config_(config),
      width_(static_cast<std::uint32_t>(width)),
      leaf_size_(width_ / config.leaves_per_block),
      alone_from_(set.alone_from),
      block_size_(set.alone_from < set.boxes.size() ? 1 : width_),
      task_refs_(task_refs),
      overlap_min_(config.overlap_min * all.bounds.half_area()) {}

bool RangeSplitter::may_be_leaf(const RefRange& range) const {
  if (range.size() > width_ * kBvhLeafBlocksMax) return false;
  if (block_size_ == width_ || range.size() == 1) return true;
  const auto refs = refs_of(range.begin, range.end);
  return std::none_of(refs.begin(), refs.end(), [this](const PrimitiveRef& ref) {
    return ref.primitive >= alone_from_;  // such a one takes a leaf of its own
  });
}

// Cuts take off as little as one reference, halving takes the fewest steps to leaves of one: ranges
// are halved, whatever their boxes, from where one more cut could lead too deep.
bool RangeSplitter::begin_branch(const RefRange& range, int depth, Branch& branch) const {
  branch.range = range;
  // Where no cut follows, nothing has to move to make room for parts.
  if (config_.only_top_is_cut && !is_of_top(range)) branch.range.limit = range.end;
  branch.is_split = range.size() > leaf_size_ || !may_be_leaf(range);
  const auto halvings = static_cast<int>(std::bit_width(range.size() - 1));
  return branch.is_split && depth + halvings <= kBvhDepthMax;
}

Branch RangeSplitter::branch_of(const RefRange& range, int depth, SahBins& bins) const {
  Branch branch;
  if (!begin_branch(range, depth, branch)) return branch;
  branch.cut = bins.cut(refs_, range, block_size_);
  cut_in_space(branch);
  return branch;
}

Branch RangeSplitter::branch_of_bins(const RefRange& range, int depth, const SahBins& bins) const {
  Branch branch;
  if (!begin_branch(range, depth, branch)) return branch;
  branch.cut = bins.best_cut(range, block_size_);
  cut_in_space(branch);
  return branch;
}

void RangeSplitter::cut_in_space(Branch& branch) const {
  if (config_.clipper == nullptr || branch.range.room() == 0) return;
  const SahCut& cut = branch.cut;
  Box4 shared = cut.left;
  shared.shrink(cut.right);
  const float overlap_min =
      std::max(overlap_min_, config_.overlap_share * branch.range.bounds.half_area());
  if (cut.axis >= 0 && !(shared.half_area() > overlap_min)) return;
  SpatialSplitter splitter(*config_.clipper);
  const SpatialCut in_space = splitter.cut(refs_, branch.range, block_size_);
  const bool is_cheaper = cut.axis < 0 || config_.cut_weight * in_space.cost < cut.cost;
  if (in_space.axis >= 0 && is_cheaper) branch.in_space = in_space;
}

std::pair<RefRange, RefRange> RangeSplitter::halves_of(const Branch& branch) const {
  if (branch.in_space.axis < 0) return SahBins::split(refs_, branch.range, branch.cut);
  return SpatialSplitter(*config_.clipper).split(refs_, branch.range, branch.in_space);
}

}  // namespace tessera::core
