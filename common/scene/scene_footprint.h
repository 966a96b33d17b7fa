// SPDX-License-Identifier: Apache-2.0
// What a slave takes in memory for a scene besides its blocks and their decoded form: the
// triangles in world space and the spatial index over them, at the height of its building. Reckoned
// from the blocks as they are, so that the master can say it before it sends them.
//
// Per triangle, from the layouts of slave/core: 36 bytes of vertices (primitive/triangle/triangle_store.h),
// 24 of its box while the index is built, and what the index takes with its builder's arrays; the
// sum is kIndexBytesPerTriangle. tests/unit/core measures that a slave stays below it.
//
// Textures: their mip levels, a third of their bytes, and while they are built the level at hand in
// floats, 15/16 of one texture (slave/core/surface/texture.h): reckoned as 4/3 of all.
// An environment map counts as one: 10 bytes to draw each of its texels of 12 (sky_map.h).
// Emitters, some 130 bytes for each triangle that sheds light, are not reckoned.
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
