// SPDX-License-Identifier: Apache-2.0
// The blocks of a scene's pictures: textures and the environment map. Layout: README.md.
// Threads. Pure functions.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace tessera {

std::vector<std::byte> encode_texture(const Texture& texture);
std::vector<std::byte> encode_environment(const EnvironmentMap& map);

// Returns: null for malformed bytes.
std::shared_ptr<const Texture> decode_texture(std::span<const std::byte> bytes);
std::shared_ptr<const EnvironmentMap> decode_environment(std::span<const std::byte> bytes);

}  // namespace tessera
