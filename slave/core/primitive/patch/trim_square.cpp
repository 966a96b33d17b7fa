// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_square.h"

namespace tessera::core {
namespace {

std::uint32_t cell_index(double x, double origin, double per_unit, std::uint32_t count) {
  return std::min(static_cast<std::uint32_t>((x - origin) * per_unit), count - 1);
}

}  // namespace

const TrimCell& TrimSquare::cell_in(const TrimGrid& grid, TrimPlace at) const {
  const std::uint32_t column = cell_index(at.u, grid.u, grid.per_u, grid.columns);
  const std::uint32_t row = cell_index(at.v, grid.v, grid.per_v, grid.rows);
  return cells_.cells[std::size_t{grid.first} + std::size_t{row} * grid.columns + column];
}

bool TrimSquare::is_kept(TrimPlace at, TrimSteps& steps) const {
  const TrimCell* cell = &whole_;
  while (cell->is_grid != 0) {
    ++steps.cells;
    cell = &cell_in(cells_.grids[cell->first], at);
  }
  return !cells_.is_odd(*cell, at.u, at.v, steps);
}

// Recursion: kTrimGridsMax deep.
Kept TrimSquare::kept_of(const TrimCell& cell, const TrimArea& area) const {
  constexpr double kBeyond = 0x1p-22;  // 4 u, within which answers are not sure
  if (cell.is_grid == 0) {
    const TrimPlace middle{(area.u0 + area.u1) / 2, (area.v0 + area.v1) / 2};
    // Answers that are sure go as far as is_near() asks for.
    const TrimPlace margin{(area.u1 - area.u0) / 2 + 2 * kBeyond,
                           (area.v1 - area.v0) / 2 + 2 * kBeyond};
    const std::uint32_t first = cell.is_ordered != 0 ? cells_.orders[cell.first].first : cell.first;
    for (std::uint32_t i = 0; i < cell.count; ++i) {
      const TrimPiece& piece = cells_.pieces[cells_.listed[first + i].piece];
      if (is_near(piece, cells_.coefficients.data(), middle, margin)) return Kept::kSome;
    }
    TrimSteps steps;
    return is_kept(middle, steps) ? Kept::kAll : Kept::kNone;
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
      const Kept kept = kept_of(next, part);
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
const TrimCell& TrimSquare::cell_of_all(TrimPlace low, TrimPlace high) const {
  const TrimCell* cell = &whole_;
  while (cell->is_grid != 0) {
    const TrimGrid& grid = cells_.grids[cell->first];
    const TrimCell* const next = &cell_in(grid, low);
    if (next != &cell_in(grid, high)) break;
    cell = next;
  }
  return *cell;
}

// Places of hits of a few rays side by side mostly lie in one cell, often without a piece.
std::uint64_t TrimSquare::kept(std::span<const TrimPlace> at, TrimPlace low, TrimPlace high) const {
  const TrimCell& cell = cell_of_all(low, high);
  return cell.is_grid != 0 ? kept_apart(cell, at) : kept_in(cell, at);
}

// Of places in a cell that is no grid.
std::uint64_t TrimSquare::kept_in(const TrimCell& cell, std::span<const TrimPlace> at) const {
  if (cell.count == 0) return cell.is_odd != 0 ? 0 : ~std::uint64_t{0} >> (64 - at.size());
  std::uint64_t bits = 0;
  TrimSteps steps;
  for (std::size_t i = 0; i < at.size(); ++i)
    bits |= std::uint64_t{!cells_.is_odd(cell, at[i].u, at[i].v, steps)} << i;
  return bits;
}

// Of places in the cell `from`. Memory of many loops comes from far away, and what a place asks is
// known only when the step before has come: so all places take each step before one takes the next.
std::uint64_t TrimSquare::kept_apart(const TrimCell& from, std::span<const TrimPlace> at) const {
  const std::size_t count = at.size();
  const TrimCell* cell[kTrimPlacesMax];
  std::fill_n(cell, count, &from);
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
    const TrimRange* const ranges = &cells_.ranges[order.range];
    __builtin_prefetch(ranges);
    __builtin_prefetch(ranges + order.ordered / 2);
    __builtin_prefetch(ranges + order.ordered - 1);
  }
  std::uint64_t bits = 0;
  TrimSteps steps;
  for (std::size_t i = 0; i < count; ++i)
    bits |= std::uint64_t{!cells_.is_odd(*cell[i], at[i].u, at[i].v, steps)} << i;
  return bits;
}

TrimMask TrimSquare::mask() const {
  TrimMask mask;
  fill(0, 0, TrimMask::kSide, mask);
  return mask;
}

// Fills in a square of cells. Recursion: to single cells, by halves.
void TrimSquare::fill(int column, int row, int side, TrimMask& mask) const {
  constexpr double kCell = 1.0 / TrimMask::kSide;
  const Kept kept =
      kept_of({kCell * column, kCell * (column + side), kCell * row, kCell * (row + side)});
  if (kept == Kept::kNone) return;
  if (kept == Kept::kSome && side > 1) {
    const int half = side / 2;
    for (const int c : {column, column + half})
      for (const int r : {row, row + half}) fill(c, r, half, mask);
    return;
  }
  const auto bits = static_cast<std::uint16_t>(((1u << side) - 1) << row);
  for (int c = column; c < column + side; ++c)
    (kept == Kept::kAll ? mask.columns[c].kept : mask.columns[c].asks) |= bits;
}

}  // namespace tessera::core
