// SPDX-License-Identifier: Apache-2.0
// Blocks of a scene without digests, which would hide the decoder behind them from mutations: the
// lengths of all but the last, 16 bits each, and then the blocks.
// Threads. Pure functions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "common/scene/scene_codec.h"

namespace tessera::test {

inline constexpr std::size_t kLooseBlocks = 8;  // those of make_surface_scene()
inline constexpr std::size_t kLooseHeadBytes = 2 * (kLooseBlocks - 1);

inline std::vector<std::byte> loose_blocks(const EncodedScene& scene) {
  if (scene.blocks.size() != kLooseBlocks) std::abort();
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < kLooseBlocks; ++i) {
    const std::size_t size = scene.blocks[i].bytes->size();
    if (size > 0xffff) std::abort();
    bytes.push_back(static_cast<std::byte>(size & 0xff));
    bytes.push_back(static_cast<std::byte>(size >> 8));
  }
  for (const SceneBlock& block : scene.blocks)
    bytes.insert(bytes.end(), block.bytes->begin(), block.bytes->end());
  return bytes;
}

// Returns: the blocks with right digests, whatever the bytes are; none where the head is cut.
inline EncodedScene scene_of_loose_blocks(std::span<const std::byte> bytes) {
  EncodedScene scene;
  if (bytes.size() < kLooseHeadBytes) return scene;
  std::span<const std::byte> rest = bytes.subspan(kLooseHeadBytes);
  std::vector<SceneBlock> blocks;
  for (std::size_t i = 0; i < kLooseBlocks; ++i) {
    const std::size_t length = i + 1 < kLooseBlocks
                                   ? std::to_integer<std::size_t>(bytes[2 * i]) |
                                         std::to_integer<std::size_t>(bytes[2 * i + 1]) << 8
                                   : rest.size();
    const auto piece = rest.first(std::min(length, rest.size()));
    rest = rest.subspan(piece.size());
    blocks.push_back(make_scene_block({piece.begin(), piece.end()}));
  }
  scene.blocks = std::move(blocks);
  return scene;
}

}  // namespace tessera::test
