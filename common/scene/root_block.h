// SPDX-License-Identifier: Apache-2.0
// The block that a scene begins with: everything small, and how many blocks follow. Layout:
// README.md. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/scene.h"

namespace tessera {

// How many blocks follow the root, in this order.
struct BlockCounts {
  std::uint64_t meshes = 0, surfaces = 0, textures = 0;
  bool has_environment_map = false, has_animation = false;

  // Whether these are all blocks but the root. Counts may be any numbers.
  bool are(std::uint64_t blocks) const {
    for (const std::uint64_t count : {meshes, surfaces, textures}) {
      if (count > blocks) return false;
      blocks -= count;
    }
    return blocks == (has_environment_map ? 1u : 0u) + (has_animation ? 1u : 0u);
  }
};

std::vector<std::byte> encode_root(const Scene& scene);

// Decodes everything but what has blocks of its own. Returns: false for malformed bytes.
bool decode_root(std::span<const std::byte> bytes, Scene& scene, BlockCounts& counts);

}  // namespace tessera
