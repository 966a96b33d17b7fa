// SPDX-License-Identifier: Apache-2.0
// Cells over the pieces of a patch's trimming loops: what a point asks is the pieces of its cell.
//
// A cell [u, u + width) x [v, v + height) lists the pieces that pass through it. From a point of it
// a path leads towards +u to the cell's right side and down that side to its lower end. A piece is
// crossed by the first part where a ray crosses it before the side, and by the second where it
// passes the side at v_edge below the point; together, whether the point is on the upper side of
// the piece as far as the cell sees it:
//   rises: v >= v_edge or a ray crosses it;  falls: v >= v_edge and no ray crosses it.
// The count's parity and the cell's own (is_odd), which is that of the path's end, make the answer.
// So loops elsewhere cost nothing, wherever they lie (grids of inclusion bits, as for polygons in
// E. Haines, "Point in polygon strategies", Graphics Gems IV, 1994; cells over trimming curves: A.
// Schollmeyer, B. Froehlich, "Direct trimming of NURBS surfaces on the GPU", SIGGRAPH 2009).
//
// is_odd is found at a point of the cell from which all listed pieces are further than what answers
// may be off by, by the list of the cell that this one was cut from. So no rounding of where a
// piece passes a border decides it. A cell in which no such point is found keeps that longer list.
//
// Grids have powers of two as sides, so borders and places of points are exact. A cell that lists
// many pieces is a grid again.
//
// Threads. Built by one, then never changed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "slave/core/primitive/patch/trim_piece.h"

namespace tessera::core {

// Grids one in the other at most, with that of the whole square.
inline constexpr int kTrimGridsMax = 5;

// Where a piece runs through a cell, from one border to another: it is nearly a parabola x = bend
// y^2, where y = n_v u - n_u v - at runs along it, from -reach to reach, and x = n_u u + n_v v
// grows from what is below the piece, for which it does not count, to what is above it, for which
// it does. Between low and high lie the values of x - bend y^2 of the piece within the cell, and
// what it and the answer may be off by. Points beside its ends, in corners of the cell, are on the
// side of the end that they are on. Most points are told by this, and of the piece itself nothing
// is asked.
struct TrimCourse {
  float n_u = 0, n_v = 0, at = 0, reach = 0, bend = 0;
  float low = -std::numeric_limits<float>::infinity();  // of a piece that ends in the cell
  float high = std::numeric_limits<float>::infinity();

  double across(double u, double v) const {
    const double y = double{n_v} * u - double{n_u} * v - double{at};
    const double within = std::clamp(y, -double{reach}, double{reach});
    return double{n_u} * u + double{n_v} * v - double{bend} * (within * within);
  }
};

struct TrimListed {
  std::uint32_t piece;
  float v_edge;  // infinite, + or - as the piece rises or falls, where it does not pass the side
  TrimCourse course = {};
};

struct TrimCell {
  std::uint32_t first = 0;  // of its list, or the number of its grid or order
  std::uint32_t count : 29 = 0;
  std::uint32_t is_grid : 1 = 0;
  std::uint32_t is_ordered : 1 = 0;  // `first` is the number of its order
  std::uint32_t is_odd : 1 = 0;
};
static_assert(sizeof(TrimCell) == 8);

struct TrimGrid {
  double u, v, per_u, per_v;  // origin, cells per unit
  std::uint32_t first, columns,
      rows;  // cell (column, row) is number first + row * columns + column
};

// The pieces of a crowded list that run through the cell, in the order in which a direction across
// them meets them. x = n_u u + n_v v grows from what is below a piece, for which the piece does not
// count, to what is above it, for which it does, and y = n_v u - n_u v - at runs along them. Taken
// away from x is what it changes by along the longest piece, tilt y + bend y^2; a piece's range
// holds its values within the cell, and what it and the answer may be off by. So only pieces whose
// range holds a point's value are asked. `ordered` pieces come first, then those that end in the
// cell or run the other way.
struct TrimOrder {
  float n_u, n_v, at, tilt, bend;
  std::uint32_t first, ordered;  // of its list
  std::uint32_t range;           // of the ordered pieces' ranges

  double along(double u, double v) const { return double{n_v} * u - double{n_u} * v - double{at}; }
  double away(double y) const { return (double{tilt} + double{bend} * y) * y; }
  double across(double u, double v) const {
    return double{n_u} * u + double{n_v} * v - away(along(u, v));
  }
};
static_assert(sizeof(TrimOrder) == 32);

struct TrimRange {
  float low;          // rises along the list
  float high_so_far;  // the most of its own high and of those before it
};

// Pieces and cells of all patches of a surface.
struct TrimCells {
  std::vector<TrimCoefficient> coefficients;
  std::vector<TrimPiece> pieces;
  std::vector<TrimListed> listed;
  std::vector<TrimCell> cells;
  std::vector<TrimGrid> grids;
  std::vector<TrimOrder> orders;
  std::vector<TrimRange> ranges;

  // Parity of the pieces that count for a point of a cell, and of the cell's own.
  bool is_odd(const TrimCell& cell, double u, double v, TrimSteps& steps) const {
    bool is_odd = cell.is_odd != 0;
    std::uint32_t from = cell.first, left = cell.count;
    if (cell.is_ordered != 0) {
      const TrimOrder& order = orders[cell.first];
      is_odd ^= is_odd_in_order(order, u, v, steps);
      from = order.first + order.ordered;
      left -= order.ordered;
    }
    steps.pieces += left;
    for (std::uint32_t i = 0; i < left; ++i) is_odd ^= counts(listed[from + i], u, v, steps.points);
    return is_odd;
  }

  bool is_odd_in_order(const TrimOrder& order, double u, double v, TrimSteps& steps) const;

  // Whether a piece counts for a point of the cell that lists it.
  bool counts(const TrimListed& of, double u, double v, std::uint64_t& points) const {
    const double x = of.course.across(u, v);
    if (x > double{of.course.high}) return true;
    if (x < double{of.course.low}) return false;
    const TrimPiece& piece = pieces[of.piece];
    const bool is_beyond = v >= double{of.v_edge};
    if (piece.falls != 0) return is_beyond && !crosses(piece, coefficients.data(), u, v, points);
    return is_beyond || crosses(piece, coefficients.data(), u, v, points);
  }
};

}  // namespace tessera::core
