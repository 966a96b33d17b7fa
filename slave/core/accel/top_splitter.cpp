// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/top_splitter.h"

#include <algorithm>
#include <utility>

#include "slave/core/accel/run_tasks.h"

namespace tessera::core {

std::deque<Halves> TopSplitter::run(Branch& root, int thread_count) {
  if (!splitter_.is_of_top(root.range)) return {};
  run_growing(std::deque{Item{&root, 0}}, thread_count, [this](const Item& item, const auto& put) {
    if (splitter_.is_cancelled()) return;
    if (item.shared == nullptr) {
      split(item, put);
    } else if (item.shared->sides.empty()) {
      bin_part(*item.shared, item.part, put);
    } else {
      order_part(*item.shared, item.part, put);
    }
  });
  shared_.clear();
  return std::move(halves_);
}

template <typename Put>
void TopSplitter::split(const Item& item, const Put& put) {
  if (item.branch->range.size() > shared_refs_) return share(item, put);
  SahBins bins;
  *item.branch = splitter_.branch_of(item.branch->range, item.depth, bins);
  if (item.branch->is_split) hang(*item.branch, item.depth, splitter_.halves_of(*item.branch), put);
}

template <typename Put>
void TopSplitter::share(const Item& item, const Put& put) {
  const std::size_t parts = (item.branch->range.size() + part_refs_ - 1) / part_refs_;
  std::unique_lock lock(mutex_);
  Shared& shared = shared_.emplace_back(item.branch, item.depth);
  lock.unlock();
  shared.bins.resize(parts);
  put_parts(shared, parts, put);
}

template <typename Put>
void TopSplitter::put_parts(Shared& shared, std::size_t count, const Put& put) {
  shared.unfinished = count;
  for (std::uint32_t part = 0; part < count; ++part)
    put(Item{shared.branch, shared.depth, &shared, part});
}

template <typename Put>
void TopSplitter::bin_part(Shared& shared, std::uint32_t part, const Put& put) {
  Branch& branch = *shared.branch;
  const auto [begin, end] = ends_of(branch.range, part);
  shared.bins[part].fill(splitter_.refs_of(begin, end), branch.range);
  if (--shared.unfinished > 0) return;
  SahBins& all = shared.bins[0];
  const std::size_t parts = shared.bins.size();
  for (std::size_t i = 1; i < parts; ++i) all.add(shared.bins[i], branch.range);
  branch = splitter_.branch_of_bins(branch.range, shared.depth, all);
  shared.bins = {};
  if (!branch.is_split) return;
  if (branch.cut.axis < 0 || branch.in_space.axis >= 0)
    return hang(branch, shared.depth, splitter_.halves_of(branch), put);
  shared.sides.resize(parts);
  put_parts(shared, parts, put);
}

template <typename Put>
void TopSplitter::order_part(Shared& shared, std::uint32_t part, const Put& put) {
  Branch& branch = *shared.branch;
  const auto [begin, end] = ends_of(branch.range, part);
  shared.sides[part] = splitter_.order(branch, begin, end);
  if (--shared.unfinished == 0)
    hang(branch, shared.depth, splitter_.join(branch, shared.sides), put);
}

template <typename Put>
void TopSplitter::hang(Branch& branch, int depth, const std::pair<RefRange, RefRange>& halves,
                       const Put& put) {
  std::unique_lock lock(mutex_);
  Halves& below = halves_.emplace_back();
  lock.unlock();
  below.left.range = halves.first;
  below.right.range = halves.second;
  branch.halves = &below;
  for (Branch* const half : {&below.left, &below.right}) {
    if (splitter_.is_of_top(half->range)) put(Item{half, depth + 1});
  }
}

std::pair<std::uint32_t, std::uint32_t> TopSplitter::ends_of(const RefRange& range,
                                                             std::uint32_t part) const {
  const std::uint32_t begin = range.begin + part * part_refs_;
  return {begin, std::min(begin + part_refs_, range.end)};
}

}  // namespace tessera::core
