// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_loops.h"

#include <algorithm>
#include <span>

#include "common/base/check.h"
#include "common/scene/validate_surface.h"
#include "slave/core/primitive/patch/trim_splitting.h"

namespace tessera::core {
namespace {

static_assert(kTrimPointsMax + kTrimDegreeMax < kTrimCoefficientsMax,
              "the coefficients of a valid surface have numbers");

// The segments of a surface's loops one after the other, with all of their points.
class LoopCursor {
 public:
  explicit LoopCursor(const PatchSurface& surface) : surface_(surface) {}

  // Steps to the next loop.
  void begin_loop() {
    TESSERA_CHECK(loop_ < surface_.segment_counts.size());
    segments_ = surface_.segment_counts[loop_++];
    TESSERA_CHECK(segments_ >= 1 && surface_.degrees.size() - segment_ >= segments_);
    first_point_ = point_;
    at_ = 0;
  }
  bool is_in_loop() const { return at_ < segments_; }
  bool is_last() const { return at_ + 1 == segments_; }
  int degree() const { return surface_.degrees[segment_]; }
  float width() const { return surface_.trim_widths.empty() ? 0 : surface_.trim_widths[segment_]; }
  // Shape: points [degree + 1].
  void take_points(std::vector<TrimPoint>& points) const {
    const auto degree = static_cast<std::size_t>(this->degree());
    TESSERA_CHECK(degree >= 1 && degree <= static_cast<std::size_t>(kTrimDegreeMax));
    TESSERA_CHECK(surface_.trim_points.size() - point_ >= degree);
    const auto first = surface_.trim_points.begin() + static_cast<std::ptrdiff_t>(point_);
    points.assign(first, first + static_cast<std::ptrdiff_t>(degree));
    const std::size_t end = is_last() ? first_point_ : point_ + degree;
    TESSERA_CHECK_LT(end, surface_.trim_points.size());
    points.push_back(surface_.trim_points[end]);
  }
  void advance() {
    point_ += static_cast<std::size_t>(degree());
    ++segment_;
    ++at_;
  }

  // Whether the loop at hand, at its first segment, is that segment and back again.
  bool is_retraced() const {
    if (segments_ != 2 || surface_.degrees[segment_] != surface_.degrees[segment_ + 1])
      return false;
    LoopCursor back = *this;
    std::vector<TrimPoint> points, of_back;
    take_points(points);
    back.advance();
    back.take_points(of_back);
    return std::equal(points.begin(), points.end(), of_back.rbegin(), of_back.rend());
  }

 private:
  const PatchSurface& surface_;
  std::size_t loop_ = 0, segment_ = 0, point_ = 0;
  std::size_t first_point_ = 0;          // of the loop at hand
  std::uint32_t segments_ = 0, at_ = 0;  // of the loop at hand
};

// What a loop adds to the coefficients: use(cursor, first coefficient, is_retraced, is_again) is
// called for each of its segments; is_again: the segment is the one before, and back.
template <class Use>
void walk_loop(LoopCursor& at, std::size_t& coefficient, const Use& use) {
  at.begin_loop();
  const bool is_retraced = at.is_retraced();
  const std::size_t begin = coefficient;
  for (bool is_again = false; at.is_in_loop(); at.advance()) {
    use(at, is_again ? begin : coefficient, is_retraced, is_again);
    if (!is_again) coefficient += static_cast<std::size_t>(at.degree());
    is_again = is_retraced;
  }
  ++coefficient;  // the loop's end
}

// Of all that loops depend on.
Digest digest_of(const PatchSurface& surface) {
  Sha256 hash;
  const auto take = [&](const auto& values) {
    const std::uint64_t count = values.size();
    hash.update(std::as_bytes(std::span(&count, 1)));
    hash.update(std::as_bytes(std::span(values)));
  };
  take(surface.loop_counts);
  take(surface.segment_counts);
  take(surface.degrees);
  take(surface.trim_points);
  std::vector<std::uint8_t> keeps;
  for (const PatchForm& form : surface.patches) keeps.push_back(form.keeps_outside);
  take(keeps);
  return hash.finish();
}

}  // namespace

TrimLoops::TrimLoops(const PatchSurface& surface, const TrimCellOptions& options) {
  if (surface.loop_counts.empty()) return;
  TESSERA_CHECK_EQ(surface.loop_counts.size(), surface.patches.size());
  LoopCursor cursor(surface);
  std::size_t coefficient = 0;
  std::vector<TrimPoint> points;
  const auto add = [&](const LoopCursor& at, std::size_t first, bool is_retraced, bool is_again) {
    TESSERA_CHECK(first < kTrimCoefficientsMax - kTrimDegreeMax);
    if (is_again) return;
    at.take_points(points);
    const int degree = at.degree();
    for (int i = 0; i < degree + (at.is_last() || is_retraced ? 1 : 0); ++i)
      cells.coefficients.push_back(coefficient_of(points[static_cast<std::size_t>(i)], degree, i));
    // It encloses nothing where it comes back, and only widens the patch.
    if (!is_retraced) split_segment(points, static_cast<std::uint32_t>(first), cells.pieces);
  };
  for (std::size_t p = 0; p < surface.patches.size(); ++p) {
    const auto first = static_cast<std::uint32_t>(cells.pieces.size());
    for (std::uint32_t i = 0; i < surface.loop_counts[p]; ++i) walk_loop(cursor, coefficient, add);
    const auto end = static_cast<std::uint32_t>(cells.pieces.size());
    // A patch without loops is whole, whatever it keeps. A set bit of a cell says: left out.
    const bool is_whole = surface.loop_counts[p] == 0 || surface.patches[p].keeps_outside != 0;
    whole.push_back(build_cells(cells, first, end, !is_whole, options));
  }
  cells.cells.shrink_to_fit();
  cells.coefficients.shrink_to_fit();
  cells.pieces.shrink_to_fit();
  cells.listed.shrink_to_fit();
  cells.grids.shrink_to_fit();
  cells.orders.shrink_to_fit();
  cells.ranges.shrink_to_fit();
  masks.reserve(whole.size());
  for (const TrimCell& patch : whole) masks.push_back(TrimSquare(cells, patch).mask());
}

std::size_t TrimLoops::bytes() const {
  return cells.coefficients.size() * sizeof(TrimCoefficient) +
         cells.pieces.size() * sizeof(TrimPiece) + cells.listed.size() * sizeof(TrimListed) +
         cells.cells.size() * sizeof(TrimCell) + cells.grids.size() * sizeof(TrimGrid) +
         cells.orders.size() * sizeof(TrimOrder) + cells.ranges.size() * sizeof(TrimRange) +
         whole.size() * sizeof(TrimCell) + masks.size() * sizeof(TrimMask);
}

std::vector<FatSegment> widened_segments(const PatchSurface& surface) {
  std::vector<FatSegment> widened;
  if (surface.trim_widths.empty()) return widened;
  LoopCursor cursor(surface);
  std::size_t coefficient = 0, patch = 0;
  const auto add = [&](const LoopCursor& at, std::size_t first, bool, bool) {
    if (!(at.width() > 0)) return;
    widened.push_back({static_cast<std::uint32_t>(patch), static_cast<std::uint32_t>(first),
                       static_cast<std::uint32_t>(at.degree()), at.width()});
  };
  for (; patch < surface.loop_counts.size(); ++patch)
    for (std::uint32_t i = 0; i < surface.loop_counts[patch]; ++i)
      walk_loop(cursor, coefficient, add);
  return widened;
}

std::shared_ptr<const TrimLoops> TrimLoopLibrary::of(const PatchSurface& surface) {
  std::shared_ptr<const TrimLoops>& loops = known_[digest_of(surface)];
  if (!loops) loops = std::make_shared<const TrimLoops>(surface, options_);
  return loops;
}

}  // namespace tessera::core
