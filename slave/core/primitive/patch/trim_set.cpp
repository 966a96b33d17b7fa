// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_set.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"

namespace tessera::core {
namespace {

// NaN becomes 0.
double in_square(double x) { return x > 0 ? std::min(x, 1.0) : 0.0; }

std::uint32_t cell_index(double x, double origin, double per_unit, std::uint32_t count) {
  return std::min(static_cast<std::uint32_t>((x - origin) * per_unit), count - 1);
}

}  // namespace

TrimSet::TrimSet(const PatchSurface& surface, const TrimCellOptions& options,
                 const FatSplitting& splitting)
    : TrimSet(surface, std::make_shared<const TrimLoops>(surface, options), splitting) {}

TrimSet::TrimSet(const PatchSurface& surface, std::shared_ptr<const TrimLoops> loops,
                 const FatSplitting& splitting)
    : loops_(std::move(loops)),
      borders_(surface, widened_segments(surface), cells().coefficients, splitting) {
  masks_.resize(loops_->whole.size());
  for (std::uint32_t p = 0; p < masks_.size(); ++p) fill(p, 0, 0, TrimMask::kSide, masks_[p]);
}

// Fills in a square of cells. Recursion: to single cells, by halves.
void TrimSet::fill(std::uint32_t patch, int column, int row, int side, TrimMask& mask) const {
  constexpr double kCell = 1.0 / TrimMask::kSide;
  const Kept kept =
      kept_of(patch, {kCell * column, kCell * (column + side), kCell * row, kCell * (row + side)});
  if (kept == Kept::kNone) return;
  if (kept == Kept::kSome && side > 1) {
    const int half = side / 2;
    for (const int c : {column, column + half})
      for (const int r : {row, row + half}) fill(patch, c, r, half, mask);
    return;
  }
  const auto bits = static_cast<std::uint16_t>(((1u << side) - 1) << row);
  for (int c = column; c < column + side; ++c)
    (kept == Kept::kAll ? mask.kept : mask.asks)[c] |= bits;
}

const TrimCell& TrimSet::cell_in(const TrimGrid& grid, TrimPlace at) const {
  const std::uint32_t column = cell_index(at.u, grid.u, grid.per_u, grid.columns);
  const std::uint32_t row = cell_index(at.v, grid.v, grid.per_v, grid.rows);
  return loops_->cells.cells[std::size_t{grid.first} + std::size_t{row} * grid.columns + column];
}

bool TrimSet::is_kept(std::uint32_t patch, double u, double v, TrimSteps& steps) const {
  if (patch >= loops_->whole.size()) return true;
  u = in_square(u);
  v = in_square(v);
  TrimCell cell = loops_->whole[patch];
  while (cell.is_grid != 0) {
    ++steps.cells;
    cell = cell_in(loops_->cells.grids[cell.first], {u, v});
  }
  return !loops_->cells.is_odd(cell, u, v, steps);
}

Kept TrimSet::kept_of(std::uint32_t patch, const TrimArea& area) const {
  if (patch >= loops_->whole.size()) return Kept::kAll;
  return kept_of(patch, loops_->whole[patch],
                 {in_square(area.u0), in_square(area.u1), in_square(area.v0), in_square(area.v1)});
}

// Recursion: kTrimGridsMax deep.
Kept TrimSet::kept_of(std::uint32_t patch, const TrimCell& cell, const TrimArea& area) const {
  constexpr double kBeyond = 0x1p-22;  // 4 u, within which answers are not sure
  if (cell.is_grid == 0) {
    const std::uint32_t first =
        cell.is_ordered != 0 ? loops_->cells.orders[cell.first].first : cell.first;
    for (std::uint32_t i = 0; i < cell.count; ++i) {
      const TrimPiece& piece = loops_->cells.pieces[loops_->cells.listed[first + i].piece];
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
  const TrimGrid& grid = loops_->cells.grids[cell.first];
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
          loops_->cells.cells[std::size_t{grid.first} + std::size_t{r} * grid.columns + c];
      const Kept kept = kept_of(patch, next, part);
      if (kept == Kept::kSome) return kept;
      is_any = is_any || kept == Kept::kAll;
      is_all = is_all && kept == Kept::kAll;
      if (is_any != is_all) return Kept::kSome;
    }
  }
  return is_any ? Kept::kAll : Kept::kNone;
}

// The last one that holds all places from `low` to `high`: numbers of cells grow with places, so
// what both corners are in holds what lies between.
const TrimCell& TrimSet::cell_of_all(std::uint32_t patch, TrimPlace low, TrimPlace high) const {
  const TrimCell* cell = &loops_->whole[patch];
  while (cell->is_grid != 0) {
    const TrimGrid& grid = loops_->cells.grids[cell->first];
    const TrimCell* const next = &cell_in(grid, low);
    if (next != &cell_in(grid, high)) break;
    cell = next;
  }
  return *cell;
}

std::uint64_t TrimSet::kept(std::uint32_t patch, std::span<const TrimPlace> places) const {
  TESSERA_CHECK_LE(places.size(), kTrimPlacesMax);
  const std::size_t count = places.size();
  if (count == 0) return 0;
  const std::uint64_t all = ~std::uint64_t{0} >> (64 - count);
  if (patch >= loops_->whole.size()) return all;
  const TrimMask& mask = masks_[patch];
  TrimPlace at[kTrimPlacesMax], low{1, 1}, high{0, 0};
  std::uint8_t number[kTrimPlacesMax];
  std::size_t asked = 0;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const TrimPlace place{in_square(places[i].u), in_square(places[i].v)};
    const int column = TrimMask::along(place.u), row = TrimMask::along(place.v);
    bits |= std::uint64_t{mask.kept[column] >> row & 1u} << i;
    if ((mask.asks[column] >> row & 1u) == 0) continue;
    at[asked] = place;
    number[asked++] = static_cast<std::uint8_t>(i);
    low = {std::min(low.u, place.u), std::min(low.v, place.v)};
    high = {std::max(high.u, place.u), std::max(high.v, place.v)};
  }
  if (asked == 0) return bits;
  // Places of hits of a few rays side by side mostly lie in one cell, often without a piece.
  const TrimCell& cell = cell_of_all(patch, low, high);
  const std::uint64_t answers =
      cell.is_grid != 0 ? kept_apart(cell, {at, asked}) : kept_in(cell, {at, asked});
  for (std::size_t i = 0; i < asked; ++i) bits |= (answers >> i & 1) << number[i];
  return bits;
}

// Of places in a cell that is no grid.
std::uint64_t TrimSet::kept_in(const TrimCell& cell, std::span<const TrimPlace> at) const {
  if (cell.count == 0) return cell.is_odd != 0 ? 0 : ~std::uint64_t{0} >> (64 - at.size());
  std::uint64_t bits = 0;
  TrimSteps steps;
  for (std::size_t i = 0; i < at.size(); ++i)
    bits |= std::uint64_t{!loops_->cells.is_odd(cell, at[i].u, at[i].v, steps)} << i;
  return bits;
}

// Of places in the cell `from`. Memory of many loops comes from far away, and what a place asks is
// known only when the step before has come: so all places take each step before one takes the next.
std::uint64_t TrimSet::kept_apart(const TrimCell& from, std::span<const TrimPlace> at) const {
  const std::size_t count = at.size();
  const TrimCell* cell[kTrimPlacesMax];
  std::fill_n(cell, count, &from);
  bool is_any_grid = true;
  while (is_any_grid) {
    is_any_grid = false;
    for (std::size_t i = 0; i < count; ++i) {
      if (cell[i]->is_grid == 0) continue;
      cell[i] = &cell_in(loops_->cells.grids[cell[i]->first], at[i]);
      __builtin_prefetch(cell[i]);
      is_any_grid = true;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (cell[i]->is_ordered != 0) {
      __builtin_prefetch(&loops_->cells.orders[cell[i]->first]);
    } else if (cell[i]->count != 0) {
      __builtin_prefetch(&loops_->cells.listed[cell[i]->first]);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (cell[i]->is_ordered == 0) continue;
    const TrimOrder& order = loops_->cells.orders[cell[i]->first];
    __builtin_prefetch(&loops_->cells.ranges[order.range]);
    __builtin_prefetch(&loops_->cells.listed[order.first]);
  }
  std::uint64_t bits = 0;
  TrimSteps steps;
  for (std::size_t i = 0; i < count; ++i)
    bits |= std::uint64_t{!loops_->cells.is_odd(*cell[i], at[i].u, at[i].v, steps)} << i;
  return bits;
}

}  // namespace tessera::core
