// SPDX-License-Identifier: Apache-2.0
// A shelf beside a plain list of what was put on it.
#include "common/wire/scene_shelf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>

namespace tessera::wire {
namespace {

// Of one chunk, or of two, which the shelf finds by its chunks, too.
SceneBlock block_of(int number) {
  return make_scene_block(std::vector<std::byte>(number % 2 == 0 ? 10 : kSceneChunkBytes + 10,
                                                 static_cast<std::byte>(number)));
}

class ListedShelf {
 public:
  explicit ListedShelf(unsigned seed) : random_(seed) {
    for (int i = 0; i < 8; ++i) pool_.push_back(block_of(i));
  }

  void change() {
    const auto what = random_() % 8;
    if (what < 6) {
      scenes_.push_back(next_scene());
      EncodedScene scene;
      scene.blocks = scenes_.back();
      shelf_.keep(++version_, scene);
      if (scenes_.size() > SceneShelf::kScenesKept) scenes_.pop_front();
    } else {
      parts_ = what == 6 ? some_blocks() : std::vector<SceneBlock>();
      shelf_.put_aside(parts_, {});
    }
  }

  void compare() {
    for (const SceneBlock& block : pool_) {
      const auto is_in = [&](const std::vector<SceneBlock>& list) {
        return std::any_of(list.begin(), list.end(),
                           [&](const SceneBlock& b) { return b.digest == block.digest; });
      };
      const bool is_here =
          is_in(parts_) || std::any_of(scenes_.begin(), scenes_.end(),
                                       [&](const auto& scene) { return is_in(scene); });
      const SceneBlock* const found = shelf_.block(block.digest, random_() % 8);
      ASSERT_EQ(found != nullptr, is_here);
      ASSERT_TRUE(found == nullptr || found->digest == block.digest);
      if (!block.chunks) continue;
      for (const Digest& chunk : *block.chunks) EXPECT_EQ(shelf_.chunk(chunk).has_value(), is_here);
    }
  }

 private:
  std::vector<SceneBlock> some_blocks() {
    std::vector<SceneBlock> blocks;
    for (auto i = random_() % 6; i > 0; --i) blocks.push_back(pool_[random_() % pool_.size()]);
    return blocks;
  }
  // Often the scene before, of which a block differs.
  std::vector<SceneBlock> next_scene() {
    std::vector<SceneBlock> blocks =
        scenes_.empty() || random_() % 4 == 0 ? some_blocks() : scenes_.back();
    if (!blocks.empty()) blocks[random_() % blocks.size()] = pool_[random_() % pool_.size()];
    return blocks;
  }

  std::mt19937 random_;
  std::vector<SceneBlock> pool_, parts_;
  std::deque<std::vector<SceneBlock>> scenes_;
  SceneVersion version_ = 0;
  SceneShelf shelf_;
};

TEST(SceneShelf, HasTheBlocksOfItsScenesAndPartsAndNothingElse) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    ListedShelf shelf(seed);
    for (int step = 0; step < 40; ++step) {
      shelf.change();
      ASSERT_NO_FATAL_FAILURE(shelf.compare());
    }
  }
}

TEST(SceneShelf, FindsScenesByTheirVersionsUntilTheseAreForgotten) {
  SceneShelf shelf;
  EncodedScene scene;
  scene.blocks = {block_of(1)};
  shelf.keep(3, scene);
  EXPECT_NE(shelf.scene(3), nullptr);
  shelf.forget_versions();
  EXPECT_EQ(shelf.scene(3), nullptr);
  EXPECT_NE(shelf.block(scene.blocks[0].digest), nullptr);
}

}  // namespace
}  // namespace tessera::wire
