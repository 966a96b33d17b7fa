// SPDX-License-Identifier: Apache-2.0
#include "common/wire/scene_shelf.h"

#include <algorithm>
#include <new>
#include <utility>

namespace tessera::wire {

namespace {

// Calls f with the blocks of `of` that are not at the same place in `other`.
template <class F>
void for_each_other(const BlockTable& of, const BlockTable& other, const F& f) {
  of.for_each_apart(other, [&](std::size_t i) {
    if (i >= other.size() || other[i].digest != of[i].digest) f(of[i]);
  });
}

}  // namespace

void SceneShelf::keep(SceneVersion version, const EncodedScene& scene, BlockNames names) {
  const Newest before = newest();
  std::size_t added = 0;
  try {
    for_each_other(scene.blocks, before.blocks, [&](const SceneBlock& block) {
      add(block);
      ++added;
    });
    kept_.push_back({version, scene, std::move(names)});
  } catch (const std::bad_alloc&) {
    for_each_other(scene.blocks, before.blocks, [&](const SceneBlock& block) {
      if (added == 0) return;
      --added;
      remove(block);
    });
    throw;
  }
  if (kept_.size() > kScenesKept) drop_oldest();
}

void SceneShelf::drop_oldest() {
  const Kept oldest = std::move(kept_.front());
  kept_.pop_front();
  const BlockTable next = kept_.empty() ? BlockTable() : kept_.front().scene.blocks;
  for_each_other(oldest.scene.blocks, next, [this](const SceneBlock& block) { remove(block); });
}

SceneShelf::Newest SceneShelf::newest() const {
  if (kept_.empty()) return {};
  return {kept_.back().names, kept_.back().scene.blocks};
}

void SceneShelf::put_aside(std::vector<SceneBlock> whole, std::vector<BlockAssembly> parts) {
  std::size_t added = 0;
  try {
    for (; added < whole.size(); ++added) add(whole[added]);
  } catch (const std::bad_alloc&) {
    while (added > 0) remove(whole[--added]);
    throw;
  }
  for (const SceneBlock& block : whole_parts_) remove(block);
  whole_parts_ = std::move(whole);
  parts_ = std::move(parts);
  is_indexed_ = false;
}

void SceneShelf::drop_parts() { put_aside({}, {}); }

void SceneShelf::add(const SceneBlock& block) {
  const auto [at, is_new] = blocks_.try_emplace(block.digest, Indexed{block, 0});
  if (is_new && block.chunks) {
    try {
      large_[block.digest] = at->second;
    } catch (const std::bad_alloc&) {
      blocks_.erase(at);
      throw;
    }
    is_indexed_ = false;
  }
  ++at->second.uses;
}

void SceneShelf::remove(const SceneBlock& block) {
  const auto indexed = blocks_.find(block.digest);
  if (--indexed->second.uses > 0) return;
  blocks_.erase(indexed);
  if (large_.erase(block.digest) > 0) is_indexed_ = false;
}

void SceneShelf::forget_versions() {
  for (Kept& kept : kept_) kept.version = 0;
}

const SceneBlock* SceneShelf::block(const Digest& digest, std::size_t place) const {
  if (!kept_.empty() && place < kept_.back().scene.blocks.size()) {
    const SceneBlock& there = kept_.back().scene.blocks[place];
    if (there.digest == digest) return &there;
  }
  const auto found = blocks_.find(digest);
  return found == blocks_.end() ? nullptr : &found->second.block;
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
    chunks_.clear();
    for (const auto& [name, indexed] : large_) {
      const SceneBlock& block = indexed.block;
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
    is_indexed_ = true;
  }
  const auto found = chunks_.find(digest);
  if (found == chunks_.end()) return std::nullopt;
  return found->second;
}

}  // namespace tessera::wire
