// SPDX-License-Identifier: Apache-2.0
// The part of validate.h that is about materials and textures.
// Threads. Pure functions.
#pragma once

#include <cstddef>
#include <string>

#include "common/base/status.h"
#include "common/scene/scene.h"

namespace tessera {

inline bool is_share(float x) { return x >= 0 && x <= 1; }  // false for NaN
inline bool is_radiance(Vec3f c) { return is_finite(c) && c.x >= 0 && c.y >= 0 && c.z >= 0; }

// `name` is such as "material 3" or "texture 0". Returns: kInvalidArgument naming the material or
// texture and its field.
Status validate_texture(const Texture& texture, const std::string& name);
Status validate_material(const Material& material, const std::string& name,
                         std::size_t texture_count);

}  // namespace tessera
