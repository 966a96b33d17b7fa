// SPDX-License-Identifier: Apache-2.0
#include "common/wire/scene_shelf.h"

#include <algorithm>
#include <utility>

namespace tessera::wire {

void SceneShelf::keep(SceneVersion version, const EncodedScene& scene) {
  kept_.push_back({version, scene});
  if (kept_.size() > kScenesKept) kept_.pop_front();
  index_blocks();
}

void SceneShelf::put_aside(std::vector<SceneBlock> whole, std::vector<BlockAssembly> parts) {
  whole_parts_ = std::move(whole);
  parts_ = std::move(parts);
  index_blocks();
}

void SceneShelf::drop_parts() { put_aside({}, {}); }

void SceneShelf::index_blocks() {
  blocks_.clear();
  for (const Kept& kept : kept_) {
    for (const SceneBlock& block : kept.scene.blocks) blocks_.emplace(block.digest, block);
  }
  for (const SceneBlock& block : whole_parts_) blocks_.emplace(block.digest, block);
  is_indexed_ = false;
}

void SceneShelf::forget_versions() {
  for (Kept& kept : kept_) kept.version = 0;
}

const SceneBlock* SceneShelf::block(const Digest& digest) const {
  const auto found = blocks_.find(digest);
  return found == blocks_.end() ? nullptr : &found->second;
}

const EncodedScene* SceneShelf::scene(SceneVersion version) const {
  for (const Kept& kept : kept_) {
    if (kept.version == version && version != 0) return &kept.scene;
  }
  return nullptr;
}

std::optional<BlockAssembly> SceneShelf::take_part(const Digest& digest) {
  const auto part = std::find_if(parts_.begin(), parts_.end(), [&](const BlockAssembly& p) {
    return p.digest() == digest && p.has_list();
  });
  if (part == parts_.end()) return std::nullopt;
  std::optional<BlockAssembly> taken(std::move(*part));
  parts_.erase(part);
  is_indexed_ = false;
  return taken;
}

std::optional<std::span<const std::byte>> SceneShelf::chunk(const Digest& digest) {
  if (!is_indexed_) {
    is_indexed_ = true;
    chunks_.clear();
    for (const auto& [name, block] : blocks_) {
      if (!block.chunks) continue;
      for (std::uint32_t i = 0; i < block.chunks->size(); ++i) {
        chunks_.emplace((*block.chunks)[i], std::span(*block.bytes)
                                                .subspan(std::size_t{i} * kSceneChunkBytes,
                                                         chunk_bytes(block.bytes->size(), i)));
      }
    }
    for (const BlockAssembly& part : parts_) {
      for (std::uint32_t i = 0; part.have_count() > 0 && i < part.count(); ++i) {
        if (part.has(i)) chunks_.emplace(part.list()[i], part.chunk(i).bytes);
      }
    }
  }
  const auto found = chunks_.find(digest);
  if (found == chunks_.end()) return std::nullopt;
  return found->second;
}

}  // namespace tessera::wire
