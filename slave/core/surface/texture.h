// SPDX-License-Identifier: Apache-2.0
// Textures and their mip levels.
//
// Levels are box-filtered in linear light, each from the one before at full precision, and kept in
// the encoding of the texture, with 8 or 16 bits as it has. They take a third of its memory and are
// half a step of an integer from the exact mean. Alpha is filtered by itself: colours are not
// weighed by it. Building takes up to as much memory again as the texture
// (common/scene/scene_footprint.h).
//
// sRGB is decoded by tables of all 256 or 65536 values, computed in double: half a rounding of a
// float.
//
// Threads. Filled once, then read by any thread.
#pragma once

#include <memory>
#include <vector>

#include "common/scene/scene.h"
#include "slave/core/surface/texture_layout.h"

namespace tessera::core {

struct MipMap {
  std::shared_ptr<const Texture> base;
  // levels[i] is level i + 1: sides halved and rounded down, to 1 x 1. They wrap as the base does;
  // none is nearest.
  std::vector<Texture> levels;
};

MipMap make_mip_map(std::shared_ptr<const Texture> texture);

// Linear RGB at uv, bilinear or nearest, wrapping. uv need not be in [0, 1].
Vec3f sample_texture(const Texture& texture, Vec2f uv);
// Does the same for one channel, 0 red to 3 alpha; alpha is never sRGB.
float sample_channel(const Texture& texture, Vec2f uv, std::uint32_t channel);

// Whether a channel has its highest value all over.
bool is_full(const Texture& texture, std::uint32_t channel);

// Coordinates in a texture that lies on a mesh as `ref` says, for coordinates `uv` of that set.
inline Vec2f mapped_uv(const TextureRef& ref, Vec2f uv) {
  const auto& m = ref.uv_map;
  return {m[0] * uv.x + m[1] * uv.y + m[2], m[3] * uv.x + m[4] * uv.y + m[5]};
}
inline bool is_moved(const TextureRef& ref) { return ref.uv_map != TextureRef().uv_map; }

// The map as the kernels see it, which look up between levels (slave/core/surface/texture-inl.h).
// Requires: the map outlives the view and stays where it is.
TextureView view_of(const MipMap& map);

std::uint64_t memory_bytes_of(const Texture& texture);

}  // namespace tessera::core
