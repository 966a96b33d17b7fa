// SPDX-License-Identifier: Apache-2.0
// What a cell sees of a piece that runs through it from border to border, and between which values
// of a direction across it, straight or bent, all of that lies.
//
// Units. Places and values are in a patch's square, [0, 1] x [0, 1]. Errors: values are wider than
// the piece by what answers may be off by (trim_piece.h), and rounded outward to float32.
//
// Threads. Pure functions of plain values.
#pragma once

#include <optional>

#include "slave/core/primitive/patch/trim_cells.h"

namespace tessera::core {

struct TrimBox {
  double u[2], v[2];
};

// Of the piece of a list, or some more of it than lies in the cell.
struct TrimStretch {
  TrimListed of;
  TrimEnd low, high;

  // Returns: nothing where the piece begins or ends within the cell, or does not reach it.
  static std::optional<TrimStretch> of_cell(const TrimCells& cells, const TrimBox& cell,
                                            const TrimListed& of);
  // How far the parameters of its ends are from having the sum 1, and how far they are apart.
  double sums_off() const;
  double parameters() const;
};

// Values of a piece, and of what answers may be off by.
struct TrimInterval {
  float low, high;

  static TrimInterval around(double low, double high);
  double width() const { return double{high} - double{low}; }
};

// Of n_u u + n_v v. Requires: |n_u|, |n_v| <= 1.
TrimInterval straight_values(const TrimStretch& seen, const TrimPiece& piece, double n_u,
                             double n_v);

// Places along a stretch, between two of which the piece is within `away` of their chord, in u and
// in v.
struct TrimPlaces {
  static constexpr int kSteps = 8;
  TrimPlace at[kSteps + 1];
  double away;

  // Returns: nothing where no such bound is known.
  static std::optional<TrimPlaces> of(const TrimStretch& seen, const TrimPiece& piece,
                                      const TrimCoefficient* coefficients);
  TrimPlace first() const { return at[0]; }
  TrimPlace middle() const { return at[kSteps / 2]; }
  TrimPlace last() const { return at[kSteps]; }

  // Of across(u, v) = n_u u + n_v v, less what is of second degree in n_v u - n_u v, with the
  // coefficient `bend`. slope: how fast it grows by u and v, over |n|, at most. Between two places
  // it is within |bend| h^2 / 4 of what is linear, for a length h by n_v u - n_u v.
  template <class Bent>
  TrimInterval values_of(const Bent& bent, double slope) const {
    double low = bent.across(at[0].u, at[0].v), high = low;
    for (int i = 1; i <= kSteps; ++i) {
      const double x = bent.across(at[i].u, at[i].v);
      low = x < low ? x : low;
      high = x > high ? x : high;
    }
    return with_room(low, high, double{bent.n_u}, double{bent.n_v}, double{bent.bend}, slope);
  }

 private:
  TrimInterval with_room(double low, double high, double n_u, double n_v, double bend,
                         double slope) const;
};

}  // namespace tessera::core
