// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/trim_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "slave/core/primitive/patch/trim_order.h"

namespace tessera::core {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

// No cell is smaller: 2^-20 is left between its border and the points at which its parity is found,
// which keep 2^-21 from all pieces.
constexpr double kSideMin = 0x1p-17;
constexpr double kMargin = 0x1p-21;
constexpr int kTrials = 32;
constexpr int kCellBitsMax = 16;  // of one grid

using List = std::vector<TrimListed>;

// Sides are powers of two, and corners multiples of them.
struct Area {
  double u = 0, v = 0, width = 1, height = 1;
};

struct Shape {
  int bits_u = 0, bits_v = 0;
};

// Cells of one row or column: from the one that holds `low` to the one that holds `high`.
struct Span {
  int from, to;
};
Span span_of(double low, double high, double origin, double per_unit, int count) {
  const auto cell = [&](double x) {
    return static_cast<int>(std::clamp(std::floor((x - origin) * per_unit), 0.0, count - 1.0));
  };
  return {cell(low), cell(high)};
}

float no_edge(const TrimPiece& piece) {
  return static_cast<float>(piece.falls != 0 ? -kInf : kInf);
}

class CellBuilder {
 public:
  CellBuilder(TrimCells& to, const TrimCellOptions& options, std::size_t entries)
      : to_(to), options_(options), entries_left_(entries) {}

  TrimCell cell_of(const Area& area, const List& list, bool is_odd, int depth) {
    const bool is_cut = depth == 0 || list.size() > static_cast<std::size_t>(options_.crowd);
    std::optional<Shape> shape;
    if (is_cut && depth < kTrimGridsMax) shape = shape_for(area, list);
    if (shape) return grid_of(area, list, is_odd, depth, *shape);
    return leaf_of(area, list, is_odd);
  }

 private:
  // The part of a piece that an area sees.
  struct Box {
    double u_low, u_high, v_low, v_high;
  };

  Box box_of(const TrimPiece& piece, double from, double to) const {
    const double u_low = std::min(piece.u[0], piece.u[1]);
    const double u_high = std::max(piece.u[0], piece.u[1]);
    Box box{std::max(u_low, from), std::min(u_high, to), piece.v[0], piece.v[1]};
    if (u_low < from) (piece.falls != 0 ? box.v_high : box.v_low) = edge(piece, from);
    if (u_high > to) (piece.falls != 0 ? box.v_low : box.v_high) = edge(piece, to);
    return box;
  }

  float edge(const TrimPiece& piece, double u) const {
    return static_cast<float>(v_at(piece, to_.coefficients.data(), u));
  }

  TrimCell leaf_of(const Area& area, List list, bool is_odd) {
    const TrimBox box{{area.u, area.u + area.width}, {area.v, area.v + area.height}};
    for (TrimListed& of : list) set_course(to_, box, of);
    const auto crowd = static_cast<std::size_t>(options_.crowd);
    if (list.size() > crowd) {
      if (const std::optional<std::uint32_t> order = add_order(to_, box, list, crowd)) {
        TrimCell cell;
        cell.first = *order;
        cell.count = static_cast<std::uint32_t>(list.size()) & 0x1fffffffu;
        cell.is_ordered = 1;
        cell.is_odd = is_odd ? 1 : 0;
        return cell;
      }
    }
    return plain_leaf_of(list, is_odd);
  }

  TrimCell plain_leaf_of(const List& list, bool is_odd) {
    TrimCell cell;
    cell.first = static_cast<std::uint32_t>(to_.listed.size());
    cell.count = static_cast<std::uint32_t>(list.size()) & 0x1fffffffu;
    cell.is_odd = is_odd ? 1 : 0;
    to_.listed.insert(to_.listed.end(), list.begin(), list.end());
    return cell;
  }

  // The grid of as many cells as there shall be in which a point meets the fewest pieces; with
  // fewer cells where their lists would be too long. A piece that does not turn passes one cell for
  // each row and column that it enters.
  std::optional<Shape> shape_for(const Area& area, const List& list) const {
    std::vector<Box> boxes;
    for (const TrimListed& of : list)
      boxes.push_back(box_of(to_.pieces[of.piece], area.u, area.u + area.width));
    const double wanted = static_cast<double>(list.size()) * options_.cells_per_piece;
    const int bits = std::min(kCellBitsMax, static_cast<int>(std::ceil(std::log2(wanted + 1))));
    std::optional<Shape> best;
    double best_mean = 0.7 * static_cast<double>(list.size());
    for (int b = bits; b >= 1 && !best; --b)
      for (int bits_u = 0; bits_u <= b; ++bits_u) {
        const Shape shape{bits_u, b - bits_u};
        if (std::ldexp(area.width, -shape.bits_u) < kSideMin) continue;
        if (std::ldexp(area.height, -shape.bits_v) < kSideMin) continue;
        const double entries = entries_of(area, boxes, shape);
        const double mean = std::ldexp(entries, -b);
        if (entries <= static_cast<double>(entries_left_) && mean < best_mean) {
          best = shape;
          best_mean = mean;
        }
      }
    return best;
  }

  static double entries_of(const Area& area, const std::vector<Box>& boxes, Shape shape) {
    const int columns = 1 << shape.bits_u, rows = 1 << shape.bits_v;
    double sum = 0;
    for (const Box& box : boxes) {
      const Span u = span_of(box.u_low, box.u_high, area.u, columns / area.width, columns);
      const Span v = span_of(box.v_low, box.v_high, area.v, rows / area.height, rows);
      sum += (u.to - u.from) + (v.to - v.from) + 1;
    }
    return sum;
  }

  TrimCell grid_of(const Area& area, const List& list, bool is_odd, int depth, Shape shape) {
    TrimGrid grid{};
    grid.u = area.u;
    grid.v = area.v;
    grid.columns = 1u << shape.bits_u;
    grid.rows = 1u << shape.bits_v;
    grid.per_u = grid.columns / area.width;
    grid.per_v = grid.rows / area.height;
    grid.first = static_cast<std::uint32_t>(to_.cells.size());
    const std::size_t count = std::size_t{grid.columns} * grid.rows;
    to_.cells.resize(to_.cells.size() + count);
    TrimCell cell;
    cell.first = static_cast<std::uint32_t>(to_.grids.size());
    cell.is_grid = 1;
    to_.grids.push_back(grid);

    std::vector<List> lists(count);
    for (const TrimListed& of : list) hand_out(of, area, grid, lists);
    for (const List& part : lists) entries_left_ -= std::min(entries_left_, part.size());
    const double width = area.width / grid.columns, height = area.height / grid.rows;
    for (std::uint32_t row = 0; row < grid.rows; ++row) {
      bool is_row_odd = is_odd;
      const double v = area.v + row * height;
      const List of_row = list_of_row(list, v, v + height, is_row_odd);
      for (std::uint32_t column = 0; column < grid.columns; ++column) {
        const std::size_t at = std::size_t{row} * grid.columns + column;
        const Area part{area.u + column * width, v, width, height};
        const std::optional<bool> parity = parity_of(part, lists[at], of_row);
        TrimCell made;
        if (parity.has_value()) {
          made = cell_of(part, lists[at], *parity != is_row_odd, depth + 1);
        } else {
          made = plain_leaf_of(of_row, is_row_odd);
        }
        to_.cells[grid.first + at] = made;
      }
    }
    return cell;
  }

  // Enters a piece in the lists of the cells that it passes.
  void hand_out(const TrimListed& of, const Area& area, const TrimGrid& grid,
                std::vector<List>& lists) const {
    const TrimPiece& piece = to_.pieces[of.piece];
    const double u_low = std::min(piece.u[0], piece.u[1]);
    const double u_high = std::max(piece.u[0], piece.u[1]);
    if (u_low >= area.u + area.width || u_high < area.u) return;
    const Span columns = span_of(u_low, u_high, area.u, grid.per_u, static_cast<int>(grid.columns));
    for (int column = columns.from; column <= columns.to; ++column) {
      const double left = area.u + column / grid.per_u, right = area.u + (column + 1) / grid.per_u;
      const Box box = box_of(piece, left, right);
      if (box.v_high < area.v || box.v_low > area.v + area.height) continue;
      const bool passes = u_low < right && right <= u_high;
      float v_edge = no_edge(piece);
      if (passes) v_edge = static_cast<float>(piece.falls != 0 ? box.v_low : box.v_high);
      const Span rows =
          span_of(box.v_low, box.v_high, area.v, grid.per_v, static_cast<int>(grid.rows));
      for (int row = rows.from; row <= rows.to; ++row)
        lists[static_cast<std::size_t>(row) * grid.columns + static_cast<std::size_t>(column)]
            .push_back({of.piece, v_edge, {}});
    }
  }

  // Those whose counts differ from point to point of [low, high); the others' go into is_odd.
  List list_of_row(const List& list, double low, double high, bool& is_odd) const {
    List of_row;
    for (const TrimListed& of : list) {
      const TrimPiece& piece = to_.pieces[of.piece];
      const bool is_beside = piece.v[1] <= low || piece.v[0] >= high;
      const bool is_beyond = of.v_edge <= low, is_before = of.v_edge >= high;
      const bool falls = piece.falls != 0;
      if (falls ? is_before : is_before && is_beside) continue;
      if (falls ? is_beyond && is_beside : is_beyond) {
        is_odd = !is_odd;
        continue;
      }
      of_row.push_back(of);
    }
    return of_row;
  }

  // Parity of what `above` counts, less that of what `list` counts, at a point of the cell that no
  // piece is near. Returns: nothing where none was found.
  std::optional<bool> parity_of(const Area& area, const List& list, const List& above) const {
    std::uint64_t points = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      // A plastic sequence (M. Roberts, 2018) in the inner three quarters; it begins in the middle.
      const auto inner = [&](double step) {
        const double x = 0.5 + trial * step;
        return 0.125 + 0.75 * (x - std::floor(x));
      };
      const TrimPlace at{area.u + area.width * inner(0.7548776662466927),
                         area.v + area.height * inner(0.5698402909980532)};
      const auto near = [&](const TrimListed& of) {
        return is_near(to_.pieces[of.piece], to_.coefficients.data(), at, {kMargin, kMargin});
      };
      if (std::any_of(list.begin(), list.end(), near)) continue;
      bool is_odd = false;
      for (const TrimListed& of : above) is_odd ^= to_.counts(of, at.u, at.v, points);
      for (const TrimListed& of : list) is_odd ^= to_.counts(of, at.u, at.v, points);
      return is_odd;
    }
    return std::nullopt;
  }

  TrimCells& to_;
  const TrimCellOptions options_;
  std::size_t entries_left_;
};

}  // namespace

TrimCell build_cells(TrimCells& to, std::uint32_t first, std::uint32_t end, bool is_odd,
                     const TrimCellOptions& options) {
  List list;
  for (std::uint32_t i = first; i < end; ++i) list.push_back({i, no_edge(to.pieces[i]), {}});
  // Of the whole square only rays count: a piece that falls counts for v_edge = -infinity alone.
  for (const TrimListed& of : list) is_odd ^= to.pieces[of.piece].falls != 0;
  const std::size_t entries = list.size() * static_cast<std::size_t>(options.entries_per_piece);
  return CellBuilder(to, options, entries).cell_of(Area{}, list, is_odd, 0);
}

}  // namespace tessera::core
