// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/tile_order.h"

#include <algorithm>
#include <array>

namespace tessera::master {
namespace {

constexpr int kEdge = 8;  // of a block, in tiles; also a band's height

struct Place {
  int column = 0, row = 0;
};

// Where position `step` of the curve through one block lies: from the top left corner to the top
// right one.
Place place_in_block(int step) {
  int column = 0, row = 0;
  for (int size = 1, rest = step; size < kEdge; size *= 2, rest /= 4) {
    const int right = (rest / 2) & 1;
    const int down = (rest ^ right) & 1;
    if (down == 0) {
      if (right == 1) {
        column = size - 1 - column;
        row = size - 1 - row;
      }
      std::swap(column, row);
    }
    column += size * right;
    row += size * down;
  }
  return {column, row};
}

std::array<Place, kEdge * kEdge> make_block() {
  std::array<Place, kEdge * kEdge> block;
  for (int step = 0; step < kEdge * kEdge; ++step)
    block[static_cast<std::size_t>(step)] = place_in_block(step);
  return block;
}

}  // namespace

std::vector<TileIndex> tile_order(int columns, int rows) {
  static const std::array<Place, kEdge* kEdge> block = make_block();
  std::vector<TileIndex> order;
  order.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const int blocks_across = (columns + kEdge - 1) / kEdge;
  for (int top = 0; top < rows; top += kEdge) {
    const bool is_backward = (top / kEdge) % 2 == 1;
    for (int across = 0; across < blocks_across; ++across) {
      const int left = (is_backward ? blocks_across - 1 - across : across) * kEdge;
      for (const Place& place : block) {
        const int column = left + (is_backward ? kEdge - 1 - place.column : place.column);
        const int row = top + place.row;
        if (column >= columns || row >= rows) continue;
        order.push_back(static_cast<TileIndex>(row) * static_cast<TileIndex>(columns) +
                        static_cast<TileIndex>(column));
      }
    }
  }
  return order;
}

}  // namespace tessera::master
