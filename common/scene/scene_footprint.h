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
// Per patch: a sub-patch has 112 bytes (slave/core/primitive/patch/patch_layout.h), its array grows
// by doubling, and with its box, the index and its builder's arrays it takes some 420 at the peak.
// The teapot's patches are cut into 142 on the mean, a sphere's into 122, a flat one is one
// sub-patch, one with a cusp 548. So this is cautious for most models and not a bound; the same
// test measures it for the teapot. Control points are held as four doubles, and copied once; a
// point of a loop with what finds it takes 96 bytes.
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
inline constexpr std::uint64_t kIndexBytesPerPatch = 160 * 450;
inline constexpr std::uint64_t kIndexBytesPerPatchNumber = 2 * 4 * 8 / 3 + 1;  // three a point
inline constexpr std::uint64_t kIndexBytesPerTrimPoint = 96;

// Returns: an estimate of the bytes; 0 for blocks that cannot be read (decoding will refuse them).
std::uint64_t index_bytes_of(const EncodedScene& scene);

}  // namespace tessera
