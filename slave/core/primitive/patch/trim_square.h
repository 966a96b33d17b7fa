// SPDX-License-Identifier: Apache-2.0
// The square of one patch, as its trimming loops cut it: what is kept at its points, of several at
// once, and of rectangles.
//
// Threads. A view of cells that no longer change.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "slave/core/primitive/patch/trim_cells.h"

namespace tessera::core {

// u0 <= u1, v0 <= v1.
struct TrimArea {
  double u0, u1, v0, v1;
};
inline constexpr std::size_t kTrimPlacesMax = 64;

enum class Kept { kNone, kSome, kAll };

// Which cells of kSide x kSide of a patch's square are kept as a whole, and in which points ask the
// loops; of the others nothing is kept.
struct alignas(64) TrimMask {
  static constexpr int kSide = 16;
  struct Column {
    std::uint16_t kept = 0, asks = 0;  // by row
  };
  Column columns[kSide];

  // Requires: x in [0, 1].
  static int along(double x) { return std::min(static_cast<int>(kSide * x), kSide - 1); }
};

// All places are in the square.
class TrimSquare {
 public:
  TrimSquare(const TrimCells& cells, const TrimCell& whole) : cells_(cells), whole_(whole) {}

  // Adds to what it took.
  bool is_kept(TrimPlace at, TrimSteps& steps) const;
  // Returns: bit i is set where at[i] is kept. low, high: corners of a rectangle around all.
  // Requires: 1 to kTrimPlacesMax places.
  std::uint64_t kept(std::span<const TrimPlace> at, TrimPlace low, TrimPlace high) const;
  // What is kept of a rectangle, its border and 2^-22 beyond it included. Conservative: kSome where
  // that is not sure.
  Kept kept_of(const TrimArea& area) const { return kept_of(whole_, area); }
  TrimMask mask() const;

 private:
  const TrimCell& cell_in(const TrimGrid& grid, TrimPlace at) const;
  const TrimCell& cell_of_all(TrimPlace low, TrimPlace high) const;
  std::uint64_t kept_in(const TrimCell& cell, std::span<const TrimPlace> at) const;
  std::uint64_t kept_apart(const TrimCell& from, std::span<const TrimPlace> at) const;
  Kept kept_of(const TrimCell& cell, const TrimArea& area) const;
  void fill(int column, int row, int side, TrimMask& mask) const;

  const TrimCells& cells_;
  const TrimCell& whole_;
};

}  // namespace tessera::core
