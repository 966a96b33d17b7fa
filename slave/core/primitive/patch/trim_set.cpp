// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_set.h"

#include <algorithm>

#include "common/base/check.h"
#include "slave/core/primitive/patch/trim_splitting.h"

namespace tessera::core {
namespace {

// Reads the loops of a surface, patch after patch.
class LoopReader {
 public:
  LoopReader(const PatchSurface& surface, TrimCells& to) : surface_(surface), to_(to) {}

  void read_loop(std::size_t patch) {
    TESSERA_CHECK(loop_ < surface_.segment_counts.size());
    const std::uint32_t segments = surface_.segment_counts[loop_++];
    TESSERA_CHECK(segments >= 1 && surface_.degrees.size() - segment_ >= segments);
    const std::size_t begin = point_;
    const std::size_t first_piece = to_.pieces.size();
    for (std::uint32_t i = 0; i < segments; ++i) {
      const std::size_t degree = surface_.degrees[segment_];
      TESSERA_CHECK(degree >= 1 && degree <= static_cast<std::size_t>(kTrimDegreeMax));
      TESSERA_CHECK(surface_.trim_points.size() - point_ >= degree);
      const auto points = surface_.trim_points.begin() + static_cast<std::ptrdiff_t>(point_);
      of_segment_.assign(points, points + static_cast<std::ptrdiff_t>(degree));
      point_ += degree;
      const std::size_t end = i + 1 == segments ? begin : point_;
      TESSERA_CHECK_LT(end, surface_.trim_points.size());
      of_segment_.push_back(surface_.trim_points[end]);
      if (segments == 2 && i == 1) is_retraced_ = is_reverse_of_before();
      add_segment(patch, i + 1 == segments);
      before_.swap(of_segment_);
      ++segment_;
    }
    // A segment and back again: it encloses nothing, and only widens the patch.
    if (is_retraced_) to_.pieces.resize(first_piece);
    is_retraced_ = false;
  }

  const std::vector<FatSegment>& widened() const { return widened_; }

 private:
  bool is_reverse_of_before() const {
    return std::equal(of_segment_.begin(), of_segment_.end(), before_.rbegin(), before_.rend());
  }

  void add_segment(std::size_t patch, bool is_last) {
    const auto first = static_cast<std::uint32_t>(to_.coefficients.size());
    TESSERA_CHECK(first < kTrimCoefficientsMax - kTrimDegreeMax);
    const int degree = static_cast<int>(of_segment_.size()) - 1;
    for (int i = 0; i < degree + (is_last ? 1 : 0); ++i)
      to_.coefficients.push_back(
          coefficient_of(of_segment_[static_cast<std::size_t>(i)], degree, i));
    split_segment(of_segment_, first, to_.pieces);
    if (surface_.trim_widths.empty() || !(surface_.trim_widths[segment_] > 0)) return;
    widened_.push_back({static_cast<std::uint32_t>(patch), first,
                        static_cast<std::uint32_t>(degree), surface_.trim_widths[segment_]});
  }

  const PatchSurface& surface_;
  TrimCells& to_;
  std::size_t loop_ = 0, segment_ = 0, point_ = 0;
  std::vector<TrimPoint> of_segment_, before_;
  bool is_retraced_ = false;
  std::vector<FatSegment> widened_;
};

// NaN becomes 0.
double in_square(double x) { return x > 0 ? std::min(x, 1.0) : 0.0; }

std::uint32_t cell_index(double x, double origin, double per_unit, std::uint32_t count) {
  return std::min(static_cast<std::uint32_t>((x - origin) * per_unit), count - 1);
}

}  // namespace

TrimSet::TrimSet(const PatchSurface& surface, const TrimCellOptions& options, double span_share) {
  if (surface.loop_counts.empty()) return;
  TESSERA_CHECK_EQ(surface.loop_counts.size(), surface.patches.size());
  LoopReader reader(surface, cells_);
  for (std::size_t p = 0; p < surface.patches.size(); ++p) {
    const auto first = static_cast<std::uint32_t>(cells_.pieces.size());
    for (std::uint32_t i = 0; i < surface.loop_counts[p]; ++i) reader.read_loop(p);
    const auto end = static_cast<std::uint32_t>(cells_.pieces.size());
    // A patch without loops is whole, whatever it keeps. A set bit of a cell says: left out.
    const bool is_whole = surface.loop_counts[p] == 0 || surface.patches[p].keeps_outside != 0;
    whole_.push_back(build_cells(cells_, first, end, !is_whole, options));
  }
  borders_ = FatBorders(surface, reader.widened(), cells_.coefficients, span_share);
  cells_.cells.shrink_to_fit();
  cells_.coefficients.shrink_to_fit();
  cells_.pieces.shrink_to_fit();
  cells_.listed.shrink_to_fit();
  cells_.grids.shrink_to_fit();
  cells_.orders.shrink_to_fit();
  cells_.ranges.shrink_to_fit();
}

const TrimCell& TrimSet::cell_in(const TrimGrid& grid, TrimPlace at) const {
  const std::uint32_t column = cell_index(at.u, grid.u, grid.per_u, grid.columns);
  const std::uint32_t row = cell_index(at.v, grid.v, grid.per_v, grid.rows);
  return cells_.cells[std::size_t{grid.first} + std::size_t{row} * grid.columns + column];
}

bool TrimSet::is_kept(std::uint32_t patch, double u, double v, TrimSteps& steps) const {
  if (patch >= whole_.size()) return true;
  u = in_square(u);
  v = in_square(v);
  TrimCell cell = whole_[patch];
  while (cell.is_grid != 0) {
    ++steps.cells;
    cell = cell_in(cells_.grids[cell.first], {u, v});
  }
  return !cells_.is_odd(cell, u, v, steps);
}

Kept TrimSet::kept_of(std::uint32_t patch, const TrimArea& area) const {
  if (patch >= whole_.size()) return Kept::kAll;
  return kept_of(patch, whole_[patch],
                 {in_square(area.u0), in_square(area.u1), in_square(area.v0), in_square(area.v1)});
}

// Recursion: kTrimGridsMax deep.
Kept TrimSet::kept_of(std::uint32_t patch, const TrimCell& cell, const TrimArea& area) const {
  constexpr double kBeyond = 0x1p-22;  // 4 u, within which answers are not sure
  if (cell.is_grid == 0) {
    const std::uint32_t first = cell.is_ordered != 0 ? cells_.orders[cell.first].first : cell.first;
    for (std::uint32_t i = 0; i < cell.count; ++i) {
      const TrimPiece& piece = cells_.pieces[cells_.listed[first + i].piece];
      const auto [u_low, u_high] = std::minmax({double{piece.u[0]}, double{piece.u[1]}});
      const auto [v_low, v_high] = std::minmax({double{piece.v[0]}, double{piece.v[1]}});
      // A piece turns back by less than the room that is left.
      if (u_low <= area.u1 + 2 * kBeyond && u_high >= area.u0 - 2 * kBeyond &&
          v_low <= area.v1 + 2 * kBeyond && v_high >= area.v0 - 2 * kBeyond)
        return Kept::kSome;
    }
    const bool is_in = is_kept(patch, (area.u0 + area.u1) / 2, (area.v0 + area.v1) / 2);
    return is_in ? Kept::kAll : Kept::kNone;
  }
  const TrimGrid& grid = cells_.grids[cell.first];
  const auto column = [&](double u) { return cell_index(u, grid.u, grid.per_u, grid.columns); };
  const auto row = [&](double v) { return cell_index(v, grid.v, grid.per_v, grid.rows); };
  // The cells on both sides of a border that is within the room are looked at.
  const std::uint32_t first_column = column(std::max(area.u0 - kBeyond, grid.u));
  const std::uint32_t first_row = row(std::max(area.v0 - kBeyond, grid.v));
  bool is_any = false, is_all = true;
  for (std::uint32_t r = first_row; r <= row(area.v1 + kBeyond); ++r) {
    for (std::uint32_t c = first_column; c <= column(area.u1 + kBeyond); ++c) {
      const double u = grid.u + c / grid.per_u, v = grid.v + r / grid.per_v;
      const TrimArea part{
          std::clamp(area.u0, u, u + 1 / grid.per_u), std::clamp(area.u1, u, u + 1 / grid.per_u),
          std::clamp(area.v0, v, v + 1 / grid.per_v), std::clamp(area.v1, v, v + 1 / grid.per_v)};
      const TrimCell& next =
          cells_.cells[std::size_t{grid.first} + std::size_t{r} * grid.columns + c];
      const Kept kept = kept_of(patch, next, part);
      if (kept == Kept::kSome) return kept;
      is_any = is_any || kept == Kept::kAll;
      is_all = is_all && kept == Kept::kAll;
      if (is_any != is_all) return Kept::kSome;
    }
  }
  return is_any ? Kept::kAll : Kept::kNone;
}

// Memory of many loops comes from far away, and what a place asks is known only when the step
// before has come: so all places take each step before one takes the next.
std::uint64_t TrimSet::kept(std::uint32_t patch, std::span<const TrimPlace> places) const {
  TESSERA_CHECK_LE(places.size(), kTrimPlacesMax);
  const std::size_t count = places.size();
  if (patch >= whole_.size())
    return count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
  TrimPlace at[kTrimPlacesMax];
  const TrimCell* cell[kTrimPlacesMax];
  for (std::size_t i = 0; i < count; ++i) {
    at[i] = {in_square(places[i].u), in_square(places[i].v)};
    cell[i] = &whole_[patch];
  }
  bool is_any_grid = true;
  while (is_any_grid) {
    is_any_grid = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (cell[i]->is_grid == 0) continue;
      cell[i] = &cell_in(cells_.grids[cell[i]->first], at[i]);
      __builtin_prefetch(cell[i]);
      is_any_grid = true;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (cell[i]->is_ordered != 0) {
      __builtin_prefetch(&cells_.orders[cell[i]->first]);
    } else if (cell[i]->count != 0) {
      __builtin_prefetch(&cells_.listed[cell[i]->first]);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (cell[i]->is_ordered == 0) continue;
    const TrimOrder& order = cells_.orders[cell[i]->first];
    __builtin_prefetch(&cells_.ranges[order.range]);
    __builtin_prefetch(&cells_.listed[order.first]);
  }
  std::uint64_t bits = 0;
  TrimSteps steps;
  for (std::size_t i = 0; i < count; ++i)
    bits |= std::uint64_t{!cells_.is_odd(*cell[i], at[i].u, at[i].v, steps)} << i;
  return bits;
}

std::size_t TrimSet::bytes() const {
  return cells_.coefficients.size() * sizeof(TrimCoefficient) +
         cells_.pieces.size() * sizeof(TrimPiece) + cells_.listed.size() * sizeof(TrimListed) +
         cells_.cells.size() * sizeof(TrimCell) + cells_.grids.size() * sizeof(TrimGrid) +
         cells_.orders.size() * sizeof(TrimOrder) + cells_.ranges.size() * sizeof(TrimRange) +
         whole_.size() * sizeof(TrimCell) + borders_.bytes();
}

}  // namespace tessera::core
