// SPDX-License-Identifier: Apache-2.0
// Store of what a receiver of scenes has: the blocks of the newest complete scenes, and the
// half-sent blocks of a scene that was broken off. A new scene takes whole blocks and single chunks
// from here before it asks for any.
//
// Threads. One owner. Pure.
// Invariants. (1) There are at most kScenesKept scenes, and the parts of one. (2) Everything here
// has had its digest checked. (3) A block of which the next kept scene has an equal one at the same
// place counts there alone, so that a scene that differs in one block of thousands changes the
// index in one place.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/base/ids.h"
#include "common/scene/scene_codec.h"
#include "common/wire/announced_blocks.h"
#include "common/wire/block_assembly.h"

namespace tessera::wire {

class SceneShelf {
 public:
  static constexpr std::size_t kScenesKept = 2;

  // `names`: those of its blocks, as they were announced. Throws: std::bad_alloc, and is then as it
  // was.
  void keep(SceneVersion version, const EncodedScene& scene, BlockNames names = {});
  // Takes the blocks of a scene that was broken off; they replace those of the one before.
  void put_aside(std::vector<SceneBlock> whole, std::vector<BlockAssembly> parts);
  void drop_parts();
  // Keeps the blocks but not the versions, which mean nothing to the next master.
  void forget_versions();

  // Returns: null when the block or scene is not here. `place`: where it may lie in the newest
  // scene, which is looked at first.
  const SceneBlock* block(const Digest& digest, std::size_t place = 0) const;
  const EncodedScene* scene(SceneVersion version) const;
  // The newest complete scene, which the next one may share chunks of its tables with.
  struct Newest {
    BlockNames names;
    BlockTable blocks;
  };
  Newest newest() const;
  // Takes out a half-sent block.
  std::optional<BlockAssembly> take_part(const Digest& digest);
  std::optional<std::span<const std::byte>> chunk(const Digest& digest);

 private:
  struct Kept {
    SceneVersion version = 0;  // 0: the scene is of another session
    EncodedScene scene;
    BlockNames names;
  };

  struct Indexed {
    SceneBlock block;
    std::uint32_t uses = 0;
  };
  using Index = std::unordered_map<Digest, Indexed, DigestHash>;

  void add(const SceneBlock& block);
  void remove(const SceneBlock& block);
  void drop_oldest();

  std::deque<Kept> kept_;
  Index blocks_, large_;  // of kept_ and whole_parts_: all, and those of several chunks
  std::vector<SceneBlock> whole_parts_;
  std::vector<BlockAssembly> parts_;
  // Where chunks of large blocks lie; the index is made when it is first asked for.
  std::unordered_map<Digest, std::span<const std::byte>, DigestHash> chunks_;
  bool is_indexed_ = false;
};

}  // namespace tessera::wire
