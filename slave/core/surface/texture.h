// Textures and their mip levels.
//
// Levels are box-filtered in linear light, each from the one before at full precision, and kept as
// bytes in the encoding of the texture: a third of its memory, half a step of a byte from the exact
// mean. Building takes up to as much again as the texture (common/scene/scene_footprint.h).
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
  std::vector<Texture> levels;  // level i + 1: sides halved and rounded down, to 1 x 1
};

MipMap make_mip_map(std::shared_ptr<const Texture> texture);

// Bilinear, repeating; linear RGB. uv need not be in [0, 1].
Vec3f sample_texture(const Texture& texture, Vec2f uv);

// For lookups by the kernels, between levels (slave/core/kernel/texture-inl.h). Requires: the map
// outlives it and stays where it is.
TextureView view_of(const MipMap& map);

}  // namespace tessera::core
