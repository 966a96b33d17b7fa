// SPDX-License-Identifier: Apache-2.0
// Puts the pieces of a crowded cell in order (TrimOrder): those that neither begin nor end within
// it and rise, or those that fall, whichever are more.
//
// Why that is right. Such a piece cuts the cell in two, from border to border, also where it begins
// or ends on one (but for the square's own): what is level with that end, and beside the piece, is
// beyond the border. n = (-, +) for those that rise, (+, +) for those that fall: a point with a
// greater x than all of the piece in the cell is not below it, or there would be a point of the
// piece to its upper left (upper right) with a greater x; and so for a smaller one. It holds for
// each piece alone, so pieces may cross and touch.
//
// What is taken away from x depends on y alone, and a piece passes each y from its one end to the
// other once. Between them a point is above what the piece is at the point's y, or below it. Beside
// an end E, which is on the cell's border, a point above the piece is to the upper left (upper
// right) of E, or there would be cell beyond the border; so its x is greater, and by the smaller of
// |n_u| and |n_v| times the way by y at least, as the greater of the two is 1. One below the piece
// is to the other side of E, and has a smaller x by as much. What is taken away may change more
// than that on the way to the cell's corner: ranges are wider by the most that it does.
//
// Threads. Pure function, but for what it appends.
#pragma once

#include <optional>
#include <vector>

#include "slave/core/primitive/patch/trim_stretch.h"

namespace tessera::core {

// Finds the course of a piece that a cell lists, where it has one.
void set_course(const TrimCells& cells, const TrimBox& cell, TrimListed& of);

// Appends order, ranges and list of a cell. Returns: its number, or nothing, and nothing is
// appended, where no more than `few` pieces have an order.
std::optional<std::uint32_t> add_order(TrimCells& to, const TrimBox& cell,
                                       const std::vector<TrimListed>& list, std::size_t few);

}  // namespace tessera::core
