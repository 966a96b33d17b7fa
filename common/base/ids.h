// SPDX-License-Identifier: Apache-2.0
// Names of things that travel. All are plain integers on the wire; none is ever reused within a
// session of the master.
#pragma once

#include <cstdint>

namespace tessera {

using SessionId = std::uint64_t;     // one life of one slave's pair of connections; never 0
using FrameId = std::uint64_t;       // counts up by one for each submitted frame, from 0
using SceneVersion = std::uint64_t;  // counts up by one for each committed scene, from 1; 0 = none
using TileIndex = std::uint32_t;     // index into the frame's TileGrid, in [0, tile_count)
using Attempt = std::uint32_t;       // which issue of a tile this is, from 1

}  // namespace tessera
