// SPDX-License-Identifier: Apache-2.0
// Sorts references into the cells of a grid over their centroids, and builds the top of a hierarchy
// over the cells instead of over the references: the first sort of the fast build. It takes three
// passes over the boxes in place of the dozen of splits that lead to ranges as small.
//
// Threads. The calling thread and up to thread_count - 1 more; the result does not depend on their
// number.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "slave/core/accel/primitive_refs.h"

namespace tessera::core {

// A range of sorted references that is split in two, or one of a few cells.
struct GridRange {
  RefRange range;
  std::uint32_t left = 0, right = 0;  // of other ranges; 0: the range is not split here
};

struct GridSorted {
  References references;          // those that have a box, without room behind them
  std::vector<GridRange> ranges;  // that of all references first; empty without references
};

// No range lies deeper than this below the first.
inline constexpr int kGridDepthMax = 24;

// Throws: std::bad_alloc.
GridSorted grid_sort(std::span<const Bounds3f> boxes, std::uint32_t block_size, int thread_count);

}  // namespace tessera::core
