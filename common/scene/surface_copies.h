// SPDX-License-Identifier: Apache-2.0
// How often a scene's freeform surfaces stand in it, from its blocks.
// Threads. Pure function.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

struct EncodedScene;  // scene_codec.h

struct SurfaceCopies {
  std::size_t block = 0;     // of the surface
  std::uint64_t copies = 0;  // instances, at least 1
};

// Returns: the surfaces that have instances, in order; none for blocks that cannot be read.
std::vector<SurfaceCopies> surface_copies_of(const EncodedScene& scene);

}  // namespace tessera
