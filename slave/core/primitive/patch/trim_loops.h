// SPDX-License-Identifier: Apache-2.0
// The trimming loops of a surface, as points of its patches' squares are asked: nothing of it
// depends on where the surface lies, nor on how its patches are shaped, so surfaces with the same
// loops share it.
//
// Memory. A segment of degree 3 has 72 bytes of coefficients; 48 for a piece, of which it has 1 to
// 2 in general; 4 to 8 cells of 8 bytes, and 36 bytes for each time that a piece passes a cell, at
// most 64 times, 8 more where the cell has an order. A patch has a mask of 64 bytes.
// slave/core/decisions/trims.md has what was measured.
//
// Threads. TrimLoops never changes once it is made. TrimLoopLibrary has one owner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "common/base/digest.h"
#include "common/scene/patch_surface.h"
#include "slave/core/primitive/patch/fat_border_spans.h"
#include "slave/core/primitive/patch/trim_grid.h"
#include "slave/core/primitive/patch/trim_square.h"

namespace tessera::core {

struct TrimLoops {
  TrimCells cells;
  std::vector<TrimCell> whole;  // [patch_count]: the square of each; empty: nothing is trimmed
  std::vector<TrimMask> masks;  // [patch_count]

  // Requires: as TrimSet. A loop of a segment and back again, which trims nothing, has the
  // coefficients of the first of the two alone.
  explicit TrimLoops(const PatchSurface& surface, const TrimCellOptions& options = {});

  bool is_trimmed(std::uint32_t patch) const {
    return patch < whole.size() &&
           (whole[patch].is_grid != 0 || whole[patch].count != 0 || whole[patch].is_odd != 0);
  }
  // Requires: there is a patch of this number.
  TrimSquare square(std::uint32_t patch) const { return {cells, whole[patch]}; }
  std::size_t bytes() const;
};

// The segments of a surface that have a width, with their places among the coefficients of its
// loops, in the order of their patches.
std::vector<FatSegment> widened_segments(const PatchSurface& surface);

// Loops of surfaces that are asked for one after the other, each made once.
class TrimLoopLibrary {
 public:
  explicit TrimLoopLibrary(const TrimCellOptions& options = {}) : options_(options) {}

  // Returns: those of a surface that was asked for before, where they are the same.
  std::shared_ptr<const TrimLoops> of(const PatchSurface& surface);

 private:
  const TrimCellOptions options_;
  std::unordered_map<Digest, std::shared_ptr<const TrimLoops>, DigestHash> known_;
};

}  // namespace tessera::core
