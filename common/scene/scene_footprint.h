// SPDX-License-Identifier: Apache-2.0
// What a slave takes in memory for a scene besides its blocks and their decoded form: the triangles
// in world space and the spatial index over them, at the peak of its build. The estimate is made
// from the blocks as they are, so that the master can give it before it sends them.
//
// Per triangle, from the layouts of slave/core: 36 bytes of vertices
// (primitive/triangle/triangle_store.h), 24 of its box while the index is built, and what the index
// takes with its builder's arrays; the sum is kIndexBytesPerTriangle. tests/unit/core measures that
// a slave stays below it.
//
// Mip levels of textures take a third of their bytes, and while they are built the level in work
// takes 15/16 of one texture in floats (slave/core/surface/texture.h): both are estimated as 4/3 of
// the bytes of all textures. An environment map counts as a texture: sampling takes 10 bytes for
// each of its texels of 12 bytes (sky_map.h). Emitters, some 130 bytes for each triangle that sheds
// light, are left out.
//
// Threads. Pure functions.
#pragma once

#include <cstdint>

#include "common/scene/scene_codec.h"

namespace tessera {

inline constexpr std::uint64_t kIndexBytesPerTriangle = 320;

// Returns: an estimate of the bytes; 0 for blocks that cannot be read (decoding will refuse them).
std::uint64_t index_bytes_of(const EncodedScene& scene);

}  // namespace tessera
