// SPDX-License-Identifier: Apache-2.0
// Which points of the patches of a surface are kept by its trimming loops.
//
// What holds. is_kept() is right for every point further than 4 u (u = 2^-24) from all loops of its
// patch, in the square's units (trim_piece.h); what is nearer gets one answer, the same on every
// instruction set. What u and v are off by themselves comes on top and is the caller's. Points
// beyond the square count as the nearest one in it, NaN as 0.
//
// Work. At most kTrimGridsMax cells one in the other, then the pieces of one list, each with at
// most kTrimStepsMax points. With loops beside each other that is one cell and fewer than two
// pieces in the mean, however many loops there are; with loops one in the other, the logarithm of
// how many pass a cell, and some two pieces (trim_order.h). All pieces of a list that has no order
// are asked: those of a patch at most, and that only where they all pass one cell of 2^-17.
//
// Memory. What loops need (trim_loops.h), which surfaces with the same loops share, and what
// borders need (fat_border_spans.h).
//
// Threads. Prepared by one thread, then never changed: any number may ask.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "common/scene/patch_surface.h"
#include "slave/core/primitive/patch/fat_border_spans.h"
#include "slave/core/primitive/patch/trim_loops.h"
#include "slave/core/primitive/patch/trim_square.h"

namespace tessera::core {

class TrimSet {
 public:
  TrimSet() : TrimSet(PatchSurface{}) {}  // of a surface without trims

  // Requires: counts that add up, loops of at least one segment, degrees of 1 to kPatchDegreesMax,
  // coordinates in [0, 1], weights > 0 and finite.
  explicit TrimSet(const PatchSurface& surface, const TrimCellOptions& options = {},
                   const FatSplitting& splitting = {});
  // loops: of the surface, or of one with the same.
  TrimSet(const PatchSurface& surface, std::shared_ptr<const TrimLoops> loops,
          const FatSplitting& splitting);

  bool is_trimmed(std::uint32_t patch) const { return loops_->is_trimmed(patch); }

  // patch: number of one of the surface's patches.
  bool is_kept(std::uint32_t patch, double u, double v) const {
    TrimSteps steps;
    return is_kept(patch, u, v, steps);
  }

  // The same, and adds to what it took.
  bool is_kept(std::uint32_t patch, double u, double v, TrimSteps& steps) const;

  // Several points of one patch. Returns: bit i is set where places[i] is kept.
  // Requires: at most kTrimPlacesMax places.
  std::uint64_t kept(std::uint32_t patch, std::span<const TrimPlace> places) const;

  // What is kept of a rectangle of a patch's square, its border and 2^-22 beyond it included.
  // Conservative: kSome where that is not sure.
  Kept kept_of(std::uint32_t patch, const TrimArea& area) const;

  const TrimLoops& loops() const { return *loops_; }
  const TrimCells& cells() const { return loops_->cells; }
  // Where the surface is met beside its widened segments (fat_border.h); answers above do not know
  // of them.
  const FatBorders& borders() const { return borders_; }

 private:
  std::shared_ptr<const TrimLoops> loops_;
  FatBorders borders_;
};

}  // namespace tessera::core
