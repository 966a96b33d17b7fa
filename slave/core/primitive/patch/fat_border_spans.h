// SPDX-License-Identifier: Apache-2.0
// The spans of a surface's widened segments (PatchSurface::trim_widths): parts of the curves that
// segments are on their patches, in space, short enough to be nearly straight.
//
// How far a span goes beside its chord: segment_bend.h.
//
// How wide it is: as the surface says, and what the decision on trims may be off by on top, which
// is 4 u of the square for the answer and u / 2 for the rounding of the segment (u = 2^-24), times
// the lengths of S_u and S_v at three places of the span.
//
// Threads. Prepared by one thread, then never changed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/patch_surface.h"
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/primitive/patch/trim_curve.h"

namespace tessera::core {

// 32 bytes. Lengths in the surface's own units.
struct FatSpan {
  double from, to;      // parameters t of its segment, multiples of a power of two; s = 1 - t
  float width;          // how far the surface reaches beyond the span
  float away;           // how far the span is from its chord at most
  std::uint32_t first;  // of its segment's coefficients
  std::uint32_t degree;
};
static_assert(sizeof(FatSpan) == 32);

// A segment with a width, > 0.
struct FatSegment {
  std::uint32_t patch, first, degree;
  float width;
};

class FatBorders {
 public:
  FatBorders() = default;  // of a surface without widths

  // Requires: segments in the order of their patches; coefficients of all of them. No span is
  // longer than span_share of its patch's extent, for the sake of its box.
  FatBorders(const PatchSurface& surface, std::span<const FatSegment> segments,
             const std::vector<TrimCoefficient>& coefficients, double span_share);

  // Numbers of the spans of a patch.
  struct Range {
    std::uint32_t first, end;
  };
  Range of_patch(std::uint32_t patch) const {
    return first_.empty() ? Range{0, 0} : Range{first_[patch], first_[patch + 1]};
  }
  const FatSpan& operator[](std::uint32_t number) const { return spans_[number]; }
  std::size_t bytes() const {
    return spans_.size() * sizeof(FatSpan) + first_.size() * sizeof(std::uint32_t);
  }

 private:
  std::vector<FatSpan> spans_;
  std::vector<std::uint32_t> first_;  // [patch_count + 1]
};

}  // namespace tessera::core
