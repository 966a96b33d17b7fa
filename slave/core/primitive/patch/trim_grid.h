// SPDX-License-Identifier: Apache-2.0
// Makes the cells of a patch (trim_cells.h), and grids of those that list many pieces.
// Threads. Pure function, but for what it appends.
#pragma once

#include <cstdint>

#include "slave/core/primitive/patch/trim_cells.h"

namespace tessera::core {

struct TrimCellOptions {
  int cells_per_piece = 4;     // of a list that is cut
  int crowd = 6;               // a list of more is cut again
  int entries_per_piece = 64;  // in the lists of all cells of a patch, at most
};

// Appends grids, cells and lists over the pieces [first, end). is_odd: parity that is added to
// all. Returns: the cell that is the whole square.
TrimCell build_cells(TrimCells& to, std::uint32_t first, std::uint32_t end, bool is_odd,
                     const TrimCellOptions& options = {});

}  // namespace tessera::core
