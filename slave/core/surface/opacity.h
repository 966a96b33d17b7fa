// SPDX-License-Identifier: Apache-2.0
// How much of a surface is there: the opacity of materials (common/scene/scene.h, Alpha).
// Threads. Pure functions.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "common/scene/scene.h"
#include "slave/core/surface/texture.h"

namespace tessera::core {

using MipMaps = std::span<const std::shared_ptr<const MipMap>>;

// Whether a ray may go through some place of a triangle of this material on this mesh.
bool may_be_passed(const Material& material, const Mesh& mesh, MipMaps textures);

// Opacity, the share of rays that stop, at (1 - u - v) A + u B + v C of a triangle of the mesh: in
// [0, 1], and 0 or 1 for a mask. Textures are looked up in their base: detail smaller than a pixel
// is left to its samples.
float opacity_at(const Material& material, const Mesh& mesh, std::size_t triangle, MipMaps textures,
                 float u, float v);

// Returns: the opacity where it is the same all over the mesh, else nothing.
std::optional<float> even_opacity(const Material& material, const Mesh& mesh);

}  // namespace tessera::core
