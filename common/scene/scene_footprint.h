// SPDX-License-Identifier: Apache-2.0
// What a slave takes in memory for a scene besides its blocks and their decoded form: triangles and
// patches in world space and the spatial index over them, at the peak of its build. The estimate is
// made from the blocks as they are, so that the master can give it before it sends them.
//
// Per triangle, from the layouts of slave/core: 36 bytes of vertices
// (primitive/triangle/triangle_store.h), 24 of its box while the index is built, and what the index
// takes with its builder's arrays; the sum is kIndexBytesPerTriangle. tests/unit/core measures that
// a slave stays below it.
//
// Per patch, from slave/core/primitive/patch/patch_layout.h: a sub-patch takes up to 120 bytes and
// in the index with its builder's arrays 70 more. The patches of the teapot are cut into 90 at most;
// a flat one is one sub-patch, one of high degree with many waves some hundreds. So this is cautious
// for most models and not a bound. Control points are held as four doubles, and copied once; a point
// of a loop with what finds it takes 96 bytes.
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
inline constexpr std::uint64_t kIndexBytesPerPatch = 90 * (120 + 70);
inline constexpr std::uint64_t kIndexBytesPerPatchNumber = 2 * 4 * 8 / 3 + 1;  // three a point
inline constexpr std::uint64_t kIndexBytesPerTrimPoint = 96;

// Returns: an estimate of the bytes; 0 for blocks that cannot be read (decoding will refuse them).
std::uint64_t index_bytes_of(const EncodedScene& scene);

}  // namespace tessera
