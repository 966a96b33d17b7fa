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
// Runs. Spans that follow one another nearly along a line may stand for one sub-patch, which very
// large scenes ask for: what a sub-patch and its place in the hierarchy take is several times what
// a span takes.
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

inline constexpr int kFatSpanDepthMax = 8;  // halvings of a segment
inline constexpr int kFatRunMax = 8;        // spans of a run

// 16 bytes. Lengths in the surface's own units.
struct FatSpan {
  float width;                       // how far the surface reaches beyond the span
  float away;                        // how far the span is from its chord at most
  std::uint32_t first : 27;          // of its segment's coefficients
  std::uint32_t degree : 4;          // of its segment
  std::uint32_t is_joined : 1;       // it goes on with the run of the span before it
  std::uint16_t from_step, to_step;  // of 2^kFatSpanDepthMax along its segment

  // Parameters t of its segment; s = 1 - t. Exact.
  double from() const { return from_step * (1.0 / (1 << kFatSpanDepthMax)); }
  double to() const { return to_step * (1.0 / (1 << kFatSpanDepthMax)); }
};
static_assert(sizeof(FatSpan) == 16);

// How widened segments are cut into spans, and these joined.
struct FatSplitting {
  double span_share = 0.25;  // of its patch's extent: no span is longer, for the sake of its box
  int run_max = 1;           // spans of a run, at most kFatRunMax
};

// A segment with a width, > 0.
struct FatSegment {
  std::uint32_t patch, first, degree;
  float width;
};

class FatBorders {
 public:
  FatBorders() = default;  // of a surface without widths

  // Requires: segments in the order of their patches; coefficients of all of them.
  FatBorders(const PatchSurface& surface, std::span<const FatSegment> segments,
             const std::vector<TrimCoefficient>& coefficients, const FatSplitting& splitting);

  // Numbers of the spans of a patch.
  struct Range {
    std::uint32_t first, end;
  };
  Range of_patch(std::uint32_t patch) const {
    return first_.empty() ? Range{0, 0} : Range{first_[patch], first_[patch + 1]};
  }
  const FatSpan& operator[](std::uint32_t number) const { return spans_[number]; }
  // Of the run that begins with a span. Requires: first < end.
  std::uint32_t end_of_run(std::uint32_t first, std::uint32_t end) const {
    std::uint32_t next = first + 1;
    while (next < end && spans_[next].is_joined != 0) ++next;
    return next;
  }
  std::size_t run_count() const { return run_count_; }
  std::size_t bytes() const {
    return spans_.size() * sizeof(FatSpan) + first_.size() * sizeof(std::uint32_t);
  }

 private:
  std::vector<FatSpan> spans_;
  std::vector<std::uint32_t> first_;  // [patch_count + 1]
  std::size_t run_count_ = 0;
};

}  // namespace tessera::core
