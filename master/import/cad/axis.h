// SPDX-License-Identifier: Apache-2.0
// One direction of a grid of patches, and a control point in space.
//
// Units. Parameters of a face or of a curve; lengths of the file. Threads. Plain values.
#pragma once

#include <cstddef>
#include <vector>

namespace tessera::import::cad {

// One direction of the grid: cell i lies between borders[i] and borders[i + 1].
struct Axis {
  std::vector<double> borders;  // parameters of the face, rising; at least 2
  bool is_angle = false;

  std::size_t cell_count() const { return borders.size() - 1; }
  double width() const { return borders.back() - borders.front(); }
  // The place of a parameter in cell `cell`; 0 and 1 at its borders, exactly.
  double local(std::size_t cell, double parameter) const;
};

// A control point of a patch and its weight, > 0.
struct Control3 {
  double x = 0, y = 0, z = 0, weight = 1;
};

}  // namespace tessera::import::cad
