// SPDX-License-Identifier: Apache-2.0
// Primitives sorted into bins by their centroid, and the cheapest border between two bins. The
// builder of the bounding volume hierarchy uses them.
//
// Threads. One thread at a time per object.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "slave/core/accel/box4.h"
#include "slave/core/accel/primitive_refs.h"

namespace tessera::core {

struct SahCut {
  int axis = -1;         // -1: all centroids coincide
  int bin = 0;           // references of this bin and those before go left
  float cost = 0;        // blocks below, weighed by area
  Box4 left{}, right{};  // of the references on each side
};

// A run of references with those of the left side in front, and the boxes of the doubled centroids
// of both sides.
struct SahSides {
  std::uint32_t begin = 0, middle = 0, end = 0;
  Box4 left{}, right{};
};

class SahBins {
 public:
  static constexpr int kBinsMax = 32;

  // Chooses the cheapest cut of `range`; the cost of leaves is counted in blocks of `block_size`.
  SahCut cut(std::span<const PrimitiveRef> refs, const RefRange& range, std::uint32_t block_size);
  // The same, on the axis on which centroids reach furthest: a third of the work.
  SahCut cut_longest(std::span<const PrimitiveRef> refs, const RefRange& range,
                     std::uint32_t block_size);

  // Orders the references of `range` by the cut, or halves them where there is none. Returns: left
  // and right part; neither is empty. Requires: range.size() > 1.
  static std::pair<RefRange, RefRange> split(std::span<PrimitiveRef> refs, const RefRange& range,
                                             const SahCut& cut);

  // The same in parts of the range, which different threads may work on: all are sorted into bins
  // of their own, those are added up, and the cut is chosen; all are ordered, and are joined.
  // Sorts `refs`, those of `range` or some of them, into bins.
  void fill(std::span<const PrimitiveRef> refs, const RefRange& range);
  void add(const SahBins& part, const RefRange& range);
  SahCut best_cut(const RefRange& range, std::uint32_t block_size) const;
  // Orders the references from `begin` to `end`. Requires: cut.axis >= 0.
  static SahSides order(std::span<PrimitiveRef> refs, const RefRange& range, const SahCut& cut,
                        std::uint32_t begin, std::uint32_t end);
  // Requires: the parts, in turn, are the range.
  static std::pair<RefRange, RefRange> join(std::span<PrimitiveRef> refs, const RefRange& range,
                                            const SahCut& cut, std::span<const SahSides> parts);

 private:
  struct Bin {
    Box4 bounds;
    std::uint32_t count = 0;

    void add(Float4 lower, Float4 upper) {
      bounds.grow(lower, upper);
      ++count;
    }
    void add(const Bin& other) {
      bounds.grow(other.bounds);
      count += other.count;
    }
  };
  // Keeps the cheapest cut between the first set's bins of the axis if it is the cheapest so far;
  // its boxes are left to the caller.
  void weigh(int axis, int bin_count, std::uint32_t block_size, SahCut& best) const;
  void set_boxes(int bin_count, SahCut& cut) const;

  Bin bins_[2][3][kBinsMax];  // the second set helps to fill the first
};

}  // namespace tessera::core
