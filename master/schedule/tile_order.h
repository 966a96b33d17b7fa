// SPDX-License-Identifier: Apache-2.0
// In which order the tiles of a frame are leased: along Hilbert curves in bands eight tiles high,
// to and fro. Pure.
//
// Tiles leased one after the other are neighbours, so a slave's caches find the same part of the
// scene, and the costs of the tiles in its queue are alike. Bands, rather than one curve over the
// picture, let the top of the picture be whole, and hashed, while its lower part is rendered.
// Source: Hilbert 1891; the curve of 8 x 8 by bits as in Warren, Hacker's Delight, 16-1.
//
// Threads. Any.
#pragma once

#include <vector>

#include "common/base/ids.h"

namespace tessera::master {

// Requires: both at least 1. Returns: each tile of a grid of columns x rows once.
std::vector<TileIndex> tile_order(int columns, int rows);

}  // namespace tessera::master
