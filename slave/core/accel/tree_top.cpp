// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/tree_top.h"

#include <algorithm>
#include <utility>

#include "slave/core/accel/top_splitter.h"

namespace tessera::core {
namespace {

bool has_cuts_below(const Branch& branch) {
  if (branch.halves == nullptr) return false;
  return branch.in_space.axis >= 0 || has_cuts_below(branch.halves->left) ||
         has_cuts_below(branch.halves->right);
}

double cost_below(const Branch& branch, const RangeSplitter& splitter) {
  if (branch.halves != nullptr)
    return cost_below(branch.halves->left, splitter) + cost_below(branch.halves->right, splitter);
  return double{branch.range.bounds.half_area()} * double{splitter.blocks_of_leaf(branch.range)};
}

References refer_to_some(const PrimitiveSet& set, const BuildControl& control,
                         const BvhBuildConfig& config, std::uint32_t step) {
  const float cuts_max = config.clipper != nullptr ? config.cuts_max : 0;
  return refer_to(set.boxes, cuts_max, control.thread_count, step);
}

// A range of at most a kTaskShare-th of all references, or of kTaskRefsMin, is split by one task;
// that makes enough tasks to keep 16 threads busy.
constexpr std::uint32_t kTaskShare = 64;
constexpr std::uint32_t kTaskRefsMin = 4096;

// A range of more than a kSharedShare-th of all references, and of more than kPartsMin parts of
// kPartRefs, is split by several tasks. Ranges below that are enough for as many threads.
constexpr std::uint32_t kSharedShare = 8;
constexpr std::uint32_t kPartsMin = 4;
constexpr std::uint32_t kPartRefs = 8192;

// Every kStepMax-th primitive tells whether cuts pay, or more of them where fewer than kSampleMin
// would be left. The longest step is odd, since neighbours often come in pairs.
constexpr std::size_t kStepMax = 7;
constexpr std::size_t kSampleMin = 32768;

}  // namespace

TreeTop::TreeTop(const PrimitiveSet& set, int width, const BuildControl& control,
                 const BvhBuildConfig& config, std::uint32_t step)
    : references_(refer_to_some(set, control, config, step)),
      splitter_({references_.refs.data(), references_.all.limit}, references_.all, set, width,
                std::max(kTaskRefsMin / step, references_.all.size() / kTaskShare), control,
                config) {
  if (references_.all.size() == 0) return;
  root_.range = references_.all;
  const std::uint32_t part_refs = std::max(kPartRefs / step, 1u);
  const std::uint32_t shared_refs =
      std::max(kPartsMin * part_refs, references_.all.size() / kSharedShare);
  TopSplitter top(splitter_, part_refs, shared_refs);
  halves_ = top.run(root_, control.thread_count);
}

bool TreeTop::has_cuts_in_space() const { return has_cuts_below(root_); }

double TreeTop::cost() const { return cost_below(root_, splitter_); }

bool do_cuts_pay(const PrimitiveSet& set, int width, const BuildControl& control,
                 const BvhBuildConfig& config) {
  const std::size_t step = std::clamp<std::size_t>(set.boxes.size() / kSampleMin, 1, kStepMax);
  const TreeTop cut(set, width, control, config, static_cast<std::uint32_t>(step));
  if (!cut.has_cuts_in_space()) return false;
  BvhBuildConfig whole = config;
  whole.clipper = nullptr;
  const TreeTop uncut(set, width, control, whole, static_cast<std::uint32_t>(step));
  return cut.cost() < uncut.cost();
}

}  // namespace tessera::core
