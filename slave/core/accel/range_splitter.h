// SPDX-License-Identifier: Apache-2.0
// How the builder of the hierarchy splits a range of references: by centroids, in space where that
// is cheaper, or in the middle where nothing tells its references apart.
//
// Threads. Calls for ranges that do not overlap may be made by different threads.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh_build_config.h"
#include "slave/core/accel/primitive_refs.h"
#include "slave/core/accel/primitive_set.h"
#include "slave/core/accel/sah_bins.h"
#include "slave/core/accel/spatial_split.h"

namespace tessera::core {

struct Halves;

// A range with the cut that splits it.
struct Branch {
  RefRange range{};
  SahCut cut{};
  SpatialCut in_space{};           // with an axis: takes the place of `cut`
  bool is_split = false;           // false: a leaf of the binary hierarchy
  const Halves* halves = nullptr;  // of a range that is split already
};

struct Halves {
  Branch left, right;
};

class RangeSplitter {
 public:
  // `width`: primitives of a full block. `all`: the range of all references. `task_refs`: most
  // references of a range that one task splits. Requires: everything that is given but the
  // configuration outlives the splitter.
  RangeSplitter(std::span<PrimitiveRef> refs, const RefRange& all, const PrimitiveSet& set,
                int width, std::uint32_t task_refs, const BuildControl& control,
                const BvhBuildConfig& config);

  // Chooses the cut of a range that lies `depth` halvings below the root. Requires: no range below
  // the same root that was split lies so deep that kBvhDepthMax is passed.
  Branch branch_of(const RefRange& range, int depth, SahBins& bins) const;
  // The same, of bins that the references of the range are sorted into.
  Branch branch_of_bins(const RefRange& range, int depth, const SahBins& bins) const;
  // Orders the references by the cut. Requires: branch.is_split.
  std::pair<RefRange, RefRange> halves_of(const Branch& branch) const;
  // The same in parts, by a cut between bins (SahBins).
  SahSides order(const Branch& branch, std::uint32_t begin, std::uint32_t end) const {
    return SahBins::order(refs_, branch.range, branch.cut, begin, end);
  }
  std::pair<RefRange, RefRange> join(const Branch& branch, std::span<const SahSides> parts) const {
    return SahBins::join(refs_, branch.range, branch.cut, parts);
  }

  // Whether the range is too large to be one task's.
  bool is_of_top(const RefRange& range) const { return range.size() > task_refs_; }
  // Whether one leaf may hold the range.
  bool may_be_leaf(const RefRange& range) const;
  // Blocks that the range takes as a leaf.
  float blocks_of_leaf(const RefRange& range) const { return blocks_of(range.size(), block_size_); }
  std::span<const PrimitiveRef> refs_of(std::uint32_t begin, std::uint32_t end) const {
    return refs_.subspan(begin, end - begin);
  }
  bool is_cancelled() const { return control_.is_to_stop(); }

 private:
  // A branch without a cut. Returns: whether one is to be chosen.
  bool begin_branch(const RefRange& range, int depth, Branch& branch) const;
  void cut_in_space(Branch& branch) const;

  const std::span<PrimitiveRef> refs_;
  const BuildControl& control_;
  const BvhBuildConfig config_;
  const std::uint32_t width_;
  const std::uint32_t leaf_size_;  // most primitives of a leaf that is not split further
  const std::uint32_t alone_from_;
  const std::uint32_t block_size_;  // 1 where some primitives take a leaf each
  const std::uint32_t task_refs_;
  const float overlap_min_;
};

}  // namespace tessera::core
