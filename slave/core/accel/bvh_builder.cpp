// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/bvh_builder.h"

#include <new>
#include <string>
#include <utility>
#include <vector>

#include "slave/core/accel/bvh_fragment.h"
#include "slave/core/accel/bvh_reinsertion.h"
#include "slave/core/accel/range_splitter.h"
#include "slave/core/accel/run_tasks.h"
#include "slave/core/accel/task_crew.h"
#include "slave/core/accel/tree_top.h"

namespace tessera::core {
namespace {

// The root of a fragment.
struct Start {
  RefRange range;
  int depth;
};

template <int W>
class Builder {
 public:
  Builder(const RangeSplitter& splitter, const LeafWriter& leaves, const BvhBuildConfig& config,
          int thread_count)
      : splitter_(splitter), leaves_(leaves), config_(config), thread_count_(thread_count) {}

  // Builds all fragments below the top's root. The result does not depend on the number of threads,
  // for the top is cut into fragments by counts alone. Returns: them; what they hold is of no use
  // after a cancellation.
  std::vector<BvhFragment<W>> run(const Branch& root) {
    fragments_.emplace_back();
    lay_out(root, 0);
    for (std::size_t i = 0; i < starts_.size(); ++i) {
      const std::size_t blocks = starts_[i].range.size() / W * 5 / 4 + 1;
      make_room<W>(leaves_, blocks, fragments_[i + 1]);
      fragments_[i + 1].tree.reserve(2 * blocks);
    }
    const auto count = static_cast<int>(starts_.size());
    run_tasks(count, thread_count_, [this](int i) { grow(static_cast<std::size_t>(i)); });
    if (splitter_.is_cancelled()) return std::move(fragments_);
    weigh_top();
    FragmentCutter<W> cutter(fragments_, splitter_);
    cutter.cut_top();
    run_tasks(count, thread_count_, [&](int i) {
      const auto fragment = static_cast<std::uint32_t>(i + 1);
      cutter.cut(fragment);
      fragments_[fragment].tree = {};
    });
    return std::move(fragments_);
  }

 private:
  // Appends to the top what is split already, and a fragment for each range that is not.
  void lay_out(const Branch& branch, int depth) {
    std::vector<BinaryNode<W>>& top = fragments_[0].tree;
    const std::size_t index = top.size();
    top.push_back({branch.range.bounds});
    if (branch.halves == nullptr) {
      top[index].linked = static_cast<std::uint32_t>(fragments_.size());
      fragments_.emplace_back();
      starts_.push_back({branch.range, depth});
      return;
    }
    lay_out(branch.halves->left, depth + 1);
    const auto right = static_cast<std::uint32_t>(fragments_[0].tree.size());
    fragments_[0].tree[index].right = right;
    lay_out(branch.halves->right, depth + 1);
  }

  void grow(std::size_t start) {
    BvhFragment<W>& fragment = fragments_[start + 1];
    const Start& from = starts_[start];
    FragmentGrower<W> grower(splitter_, config_, fragment);
    fragment.costs = grower.grow(from.range, from.depth);
    if (config_.reinsertions > 0 && !splitter_.is_cancelled())
      FragmentMover<W>(splitter_, config_, fragment).move(from.depth);
  }

  void weigh_top() {
    std::vector<BinaryNode<W>>& top = fragments_[0].tree;
    std::vector<SlotCosts<W>> costs(top.size());
    for (std::size_t i = top.size(); i-- > 0;) {
      if (top[i].linked != 0) {
        costs[i] = fragments_[top[i].linked].costs;
        continue;
      }
      const WholeCosts whole{0, false, config_.cost_node * top[i].bounds.half_area()};
      costs[i] = costs_of_halves(costs[i + 1], costs[top[i].right], whole, top[i].plan);
    }
  }

  const RangeSplitter& splitter_;
  const LeafWriter& leaves_;
  const BvhBuildConfig& config_;
  const int thread_count_;
  std::vector<BvhFragment<W>> fragments_;  // the top first
  std::vector<Start> starts_;              // of the others
};

template <int W>
Result<Bvh<W>> build(const PrimitiveSet& set, const BuildControl& control,
                     const BvhBuildConfig& config) {
  BvhBuildConfig chosen = config;
  if (config.cuts_have_to_pay && !do_cuts_pay(set, W, control, config)) {
    chosen.clipper = nullptr;
    // Where boxes hardly overlap, those of parts of a block are hardly smaller.
    chosen.leaves_per_block = 1;
  }
  const TreeTop top(set, W, control, chosen);
  Bvh<W> bvh;
  if (top.all().size() == 0) return bvh;
  bvh.bounds = top.all().bounds.bounds();
  const RangeSplitter& splitter = top.splitter();
  const Status cancelled = Status::cancelled("the build of the spatial index was cancelled");
  if (splitter.is_cancelled()) return cancelled;
  auto fragments = Builder<W>(splitter, set.leaves, config, control.thread_count).run(top.root());
  if (splitter.is_cancelled()) return cancelled;
  Result<std::vector<PartBase>> bases =
      join_parts(std::span(fragments), set, control.thread_count, bvh);
  if (!bases.is_ok()) return bases.status();
  for (std::size_t i = 0; i < fragments.size(); ++i) {
    for (const Bough& bough : fragments[i].boughs)
      bvh.nodes[bough.parent].child[bough.slot] = (*bases)[i].moved(bough.reference);
  }
  return bvh;
}

}  // namespace

template <int W>
Result<Bvh<W>> build_bvh(const PrimitiveSet& set, const BuildControl& control,
                         const BvhBuildConfig& config) {
  try {
    const TaskCrew crew;
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
