// SPDX-License-Identifier: Apache-2.0
// Splits the ranges of the top of a binary hierarchy on several threads. Ranges that hold a large
// share of all references are split in parts, so that threads have work from the root on, but for
// cuts in space, which one thread makes; parts are cut by counts alone, and the result does not
// depend on the number of threads.
//
// Threads. One owner; run() works on several.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <vector>

#include "slave/core/accel/range_splitter.h"
#include "slave/core/accel/sah_bins.h"

namespace tessera::core {

class TopSplitter {
 public:
  // `part_refs`: references of a part. `shared_refs`: a range of more is split in parts; at least
  // twice as many. Requires: the splitter outlives it.
  TopSplitter(const RangeSplitter& splitter, std::uint32_t part_refs, std::uint32_t shared_refs)
      : splitter_(splitter), part_refs_(part_refs), shared_refs_(shared_refs) {}

  // Splits all ranges below `root` that are too large to be one task's. Returns: where their halves
  // are kept; they are incomplete after a cancellation. Throws: std::bad_alloc.
  std::deque<Halves> run(Branch& root, int thread_count);

 private:
  // A range that is split in parts: all are sorted into bins, then all are ordered by the cut.
  struct Shared {
    Shared(Branch* whole, int below_root) : branch(whole), depth(below_root) {}

    Branch* const branch;
    const int depth;
    std::vector<SahBins> bins;
    std::vector<SahSides> sides;
    std::atomic<std::size_t> unfinished{0};  // parts of what is under way
  };
  // A range, or a part of one that is shared.
  struct Item {
    Branch* branch = nullptr;
    int depth = 0;
    Shared* shared = nullptr;
    std::uint32_t part = 0;
  };

  template <typename Put>
  void split(const Item& item, const Put& put);
  template <typename Put>
  void share(const Item& item, const Put& put);
  template <typename Put>
  void put_parts(Shared& shared, std::size_t count, const Put& put);
  template <typename Put>
  void bin_part(Shared& shared, std::uint32_t part, const Put& put);
  template <typename Put>
  void order_part(Shared& shared, std::uint32_t part, const Put& put);
  // Hangs both halves below a branch, and puts in what is still too large.
  template <typename Put>
  void hang(Branch& branch, int depth, const std::pair<RefRange, RefRange>& halves, const Put& put);
  std::pair<std::uint32_t, std::uint32_t> ends_of(const RefRange& range, std::uint32_t part) const;

  const RangeSplitter& splitter_;
  const std::uint32_t part_refs_, shared_refs_;
  std::mutex mutex_;  // of what follows, but for the elements
  std::deque<Halves> halves_;
  std::deque<Shared> shared_;
};

}  // namespace tessera::core
