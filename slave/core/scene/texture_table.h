// SPDX-License-Identifier: Apache-2.0
// The textures that surfaces of a material are made of, put together for the kernels once for a
// scene. The opacity of a material is not among them: rays ask for it before there is a surface.
//
// To add a lookup: a name in TextureUse (slave/core/surface/detail_layout.h), a line in
// textures_by_use(), and what SurfaceDetail::take() is to do with the texel.
//
// Threads. Pure functions.
#pragma once

#include <array>
#include <span>

#include "common/scene/scene.h"
#include "slave/core/surface/detail_layout.h"

namespace tessera::core {

// Shape: by TextureUse.
inline std::array<const TextureRef*, kTextureUses> textures_by_use(const Material& m) {
  return {&m.albedo_texture,
          &m.emission_texture,
          &m.roughness_metalness_texture,
          &m.normal_texture,
          &m.specular_texture,
          &m.specular_color_texture,
          &m.clearcoat.weight_texture,
          &m.clearcoat.roughness_texture,
          &m.clearcoat.normal_texture,
          &m.sheen.color_texture,
          &m.sheen.roughness_texture,
          &m.transmission.weight_texture,
          &m.anisotropy.texture};
}

bool has_texture(const Material& material);

// views: of the scene's textures, by index; the table keeps pointers to them.
TextureTable make_texture_table(const Material& material, std::span<const TextureView> views);

}  // namespace tessera::core
