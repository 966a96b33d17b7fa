// SPDX-License-Identifier: Apache-2.0
// Scene chunks in, complete scenes out; a sender that breaks the rules is found out.
#include "common/wire/scene_receiver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

namespace tessera::wire {
namespace {

using Actions = SceneReceiver::Actions;
using Bytes = std::vector<std::byte>;

Bytes bytes_of(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

Bytes copy_of(const BlockBytes& bytes) { return {bytes->begin(), bytes->end()}; }

// A block of `chunks` chunks, the last of them short.
Bytes large(std::uint32_t chunks, std::uint32_t seed) {
  std::mt19937 random(seed);
  Bytes bytes(chunks * kSceneChunkBytes - 1000);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random());
  return bytes;
}

SceneAnnounce announce_of(SceneVersion version, const std::vector<Bytes>& blocks) {
  SceneAnnounce a;
  a.version = version;
  for (const Bytes& block : blocks) {
    a.digests.push_back(make_scene_block(block).digest);
    a.sizes.push_back(block.size());
  }
  return a;
}
SceneAnnounce announce_texts(SceneVersion version, const std::vector<std::string>& texts) {
  std::vector<Bytes> blocks;
  for (const std::string& text : texts) blocks.push_back(bytes_of(text));
  return announce_of(version, blocks);
}

SceneChunk piece(SceneVersion version, std::uint32_t block, std::uint64_t offset, Bytes bytes) {
  return {version, block, offset, net::SharedBytes::of(std::move(bytes))};
}
SceneChunk whole(SceneVersion version, std::uint32_t block, const std::string& text) {
  return piece(version, block, 0, bytes_of(text));
}
SceneChunk chunk_of(SceneVersion version, std::uint32_t block, const Bytes& bytes,
                    std::uint32_t index) {
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(index * kSceneChunkBytes);
  return piece(version, block, std::uint64_t{index} * kSceneChunkBytes,
               {begin, begin + static_cast<std::ptrdiff_t>(chunk_bytes(bytes.size(), index))});
}
SceneChunkList list_of(SceneVersion version, std::uint32_t block, const Bytes& bytes) {
  return {version, block, chunk_digests(bytes)};
}

// Answers needs as a sender would. Returns: how many chunks were sent.
std::size_t serve(SceneReceiver& receiver, Actions& actions, const std::vector<Bytes>& blocks,
                  std::size_t chunks_max = 1u << 30) {
  std::size_t sent = 0;
  while (!actions.need.empty() || !actions.chunk_need.empty()) {
    const auto needs = std::exchange(actions.need, {});
    const auto chunk_needs = std::exchange(actions.chunk_need, {});
    for (const SceneNeed& need : needs) {
      for (const std::uint32_t block : need.blocks) {
        if (is_one_chunk(blocks[block].size())) {
          EXPECT_TRUE(
              receiver.chunk(piece(need.version, block, 0, blocks[block]), actions).is_ok());
          ++sent;
        } else {
          EXPECT_TRUE(receiver.list(list_of(need.version, block, blocks[block]), actions).is_ok());
        }
      }
    }
    for (const SceneChunkNeed& need : chunk_needs) {
      for (std::uint32_t i = 0; i < need.chunks.size() && sent < chunks_max; ++i) {
        if (!need.chunks[i]) continue;
        EXPECT_TRUE(
            receiver.chunk(chunk_of(need.version, need.block, blocks[need.block], i), actions)
                .is_ok());
        ++sent;
      }
    }
  }
  return sent;
}

TEST(SceneReceiver, BlocksMayInterleaveAndEqualOnesAreAskedForOnce) {
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_texts(1, {"root", "mesh", "mesh"}), actions).is_ok());
  ASSERT_EQ(actions.need.size(), 1u);
  EXPECT_EQ(actions.need[0].blocks, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_TRUE(receiver.chunk(whole(1, 1, "mesh"), actions).is_ok());
  EXPECT_TRUE(actions.complete.empty());
  EXPECT_TRUE(receiver.chunk(whole(1, 0, "root"), actions).is_ok());
  ASSERT_EQ(actions.complete.size(), 1u);
  const EncodedScene& scene = actions.complete[0].scene;
  ASSERT_EQ(scene.blocks.size(), 3u);
  EXPECT_EQ(copy_of(scene.blocks[2].bytes), bytes_of("mesh"));
  EXPECT_EQ(scene.blocks[1].bytes, scene.blocks[2].bytes) << "one copy";
}

TEST(SceneReceiver, ALargeBlockComesInAnyOrderByItsList) {
  const Bytes block = large(5, 1);
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {block}), actions).is_ok());
  ASSERT_TRUE(receiver.list(list_of(1, 0, block), actions).is_ok());
  ASSERT_EQ(actions.chunk_need.size(), 1u);
  EXPECT_EQ(actions.chunk_need[0].chunks, std::vector<bool>(5, true));
  for (const std::uint32_t i : {4u, 0u, 3u, 1u}) {
    ASSERT_TRUE(receiver.chunk(chunk_of(1, 0, block, i), actions).is_ok());
    net::SharedBytes held;
    EXPECT_EQ(receiver.find(1, 0, i, held), SceneReceiver::Holding::kHere) << "to be passed on";
    EXPECT_TRUE(std::ranges::equal(held.bytes, chunk_of(1, 0, block, i).bytes.bytes));
    EXPECT_EQ(receiver.find(1, 0, 2, held), SceneReceiver::Holding::kNotYet);
  }
  EXPECT_TRUE(actions.complete.empty());
  ASSERT_TRUE(receiver.chunk(chunk_of(1, 0, block, 2), actions).is_ok());
  ASSERT_EQ(actions.complete.size(), 1u);
  EXPECT_EQ(copy_of(actions.complete[0].scene.blocks[0].bytes), block);
  EXPECT_EQ(actions.arrived.size(), 5u);
}

TEST(SceneReceiver, AnUpdateBringsOnlyTheChunksThatChanged) {
  Bytes block = large(40, 2);
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {block}), actions).is_ok());
  EXPECT_EQ(serve(receiver, actions, {block}), 40u);
  block[17 * kSceneChunkBytes + 5] ^= std::byte{1};
  block.insert(block.end(), 3000, std::byte{7});  // grows: the last chunk changes, one is new
  ASSERT_TRUE(receiver.announce(announce_of(2, {block}), actions).is_ok());
  EXPECT_EQ(serve(receiver, actions, {block}), 3u);
  ASSERT_EQ(actions.complete.size(), 2u);
  EXPECT_EQ(copy_of(actions.complete[1].scene.blocks[0].bytes), block);
}

TEST(SceneReceiver, ABrokenTransferGoesOnWhereItWas) {
  const std::vector<Bytes> blocks = {bytes_of("root"), large(30, 3), bytes_of("small")};
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(5, blocks), actions).is_ok());
  EXPECT_EQ(serve(receiver, actions, blocks, 22), 22u);
  receiver.reset();
  net::SharedBytes held;
  EXPECT_EQ(receiver.find(5, 1, 0, held), SceneReceiver::Holding::kNotYet)
      << "another session: what it will announce is not known";
  ASSERT_TRUE(receiver.announce(announce_of(1, blocks), actions).is_ok());
  EXPECT_EQ(serve(receiver, actions, blocks), 10u);  // the rest of 32
  ASSERT_EQ(actions.complete.size(), 1u);
  EXPECT_EQ(copy_of(actions.complete[0].scene.blocks[1].bytes), blocks[1]);
}

TEST(SceneReceiver, ARetiredTransferIsOfUseToTheNext) {
  Bytes block = large(20, 4);
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {block}), actions).is_ok());
  EXPECT_EQ(serve(receiver, actions, {block}, 12), 12u);
  block.back() ^= std::byte{1};
  ASSERT_TRUE(receiver.announce(announce_of(2, {block}), actions).is_ok());
  receiver.retire(2, actions);
  EXPECT_TRUE(receiver.chunk(chunk_of(1, 0, block, 13), actions).is_ok()) << "was under way";
  EXPECT_EQ(serve(receiver, actions, {block}), 8u);
  EXPECT_EQ(actions.complete.size(), 1u);
}

TEST(SceneReceiver, CodedChunksAreTheSame) {
  Bytes block = large(3, 5);
  std::fill(block.begin(), block.begin() + 100'000, std::byte{0});
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {block}), actions).is_ok());
  ASSERT_TRUE(receiver.list(list_of(1, 0, block), actions).is_ok());
  for (std::uint32_t i = 0; i < 3; ++i) {
    SceneChunk chunk = chunk_of(1, 0, block, i);
    Bytes coded;
    if (code_bytes(ByteCoding::kZstd, chunk.bytes.bytes, coded)) {
      chunk.coding = ByteCoding::kZstd;
      SceneChunk bomb = chunk;
      Bytes lie;
      ASSERT_TRUE(code_bytes(ByteCoding::kZstd, Bytes(10 * kSceneChunkBytes), lie));
      bomb.bytes = net::SharedBytes::of(lie);
      EXPECT_EQ(receiver.take(bomb, actions), SceneReceiver::Verdict::kMalformed);
      chunk.bytes = net::SharedBytes::of(std::move(coded));
    }
    ASSERT_TRUE(receiver.chunk(chunk, actions).is_ok());
  }
  ASSERT_EQ(actions.complete.size(), 1u);
  EXPECT_EQ(copy_of(actions.complete[0].scene.blocks[0].bytes), block);
}

TEST(SceneReceiver, WhatAnotherSlaveAltersChangesNothing) {
  const Bytes block = large(3, 6);
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {block}), actions).is_ok());
  ASSERT_TRUE(receiver.list(list_of(1, 0, block), actions).is_ok());
  Bytes altered = block;
  altered[5] ^= std::byte{1};
  EXPECT_EQ(receiver.take(chunk_of(1, 0, altered, 0), actions),
            SceneReceiver::Verdict::kWrongDigest);
  EXPECT_EQ(receiver.take(piece(1, 0, 7, {std::byte{1}}), actions),
            SceneReceiver::Verdict::kMalformed);
  EXPECT_EQ(receiver.take(chunk_of(2, 0, block, 0), actions), SceneReceiver::Verdict::kNotAskedFor);
  EXPECT_TRUE(actions.failed.empty());
  EXPECT_EQ(receiver.take(chunk_of(1, 0, block, 0), actions), SceneReceiver::Verdict::kStored);
  EXPECT_EQ(receiver.take(chunk_of(1, 0, altered, 0), actions), SceneReceiver::Verdict::kLate);
  ASSERT_EQ(receiver.lacking().size(), 1u);
  EXPECT_EQ(receiver.lacking()[0].chunks, (std::vector<bool>{false, true, true}));
  EXPECT_EQ(receiver.head_bytes(), kSceneChunkBytes);
}

TEST(SceneReceiver, AListThatLiesFailsTheVersion) {
  const Bytes block = large(3, 7);
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {block}), actions).is_ok());
  SceneChunkList list = list_of(1, 0, block);
  std::swap(list.chunks[0], list.chunks[1]);
  ASSERT_TRUE(receiver.list(list, actions).is_ok());
  EXPECT_EQ(actions.failed.size(), 1u);
}

TEST(SceneReceiver, KeepsTheBlocksOfTwoScenes) {
  SceneReceiver receiver;
  SceneVersion version = 0;
  const auto lacking = [&](const std::string& block) {
    Actions actions;
    ++version;
    EXPECT_TRUE(receiver.announce(announce_texts(version, std::vector<std::string>{block}), actions)
                    .is_ok());
    const bool is_lacking = !actions.need.at(0).blocks.empty();
    if (is_lacking) {
      EXPECT_TRUE(receiver.chunk(whole(version, 0, block), actions).is_ok());
    }
    EXPECT_EQ(actions.complete.size(), 1u);
    return is_lacking;
  };
  EXPECT_TRUE(lacking("a"));
  EXPECT_TRUE(lacking("b"));
  EXPECT_FALSE(lacking("a"));
  EXPECT_TRUE(lacking("c"));
  EXPECT_TRUE(lacking("b"));
  version = 0;
  receiver.reset();
  EXPECT_FALSE(lacking("c")) << "blocks outlive the connection";
}

TEST(SceneReceiver, ServesOneAnnouncementAfterTheOther) {
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_texts(1, {"shared", "x"}), actions).is_ok());
  ASSERT_TRUE(receiver.announce(announce_texts(2, {"shared", "new"}), actions).is_ok());
  EXPECT_EQ(actions.need.size(), 1u);
  ASSERT_TRUE(receiver.chunk(whole(1, 0, "shared"), actions).is_ok());
  ASSERT_TRUE(receiver.chunk(whole(1, 1, "x"), actions).is_ok());
  ASSERT_EQ(actions.need.size(), 2u);
  EXPECT_EQ(actions.need[1].blocks, (std::vector<std::uint32_t>{1}));
}

TEST(SceneReceiver, WhatDoesNotFitIsRefusedBeforeItIsSent) {
  std::uint64_t free_bytes = 1000;
  SceneReceiver receiver([&](std::uint64_t) { return std::optional(free_bytes); });
  Actions actions;
  SceneAnnounce announce = announce_texts(1, {std::string(400, 'a'), std::string(50, 'b')});
  announce.index_bytes = 101;  // 2 * 450 + 101
  ASSERT_TRUE(receiver.announce(announce, actions).is_ok());
  EXPECT_TRUE(actions.need.empty());
  ASSERT_EQ(actions.failed.size(), 1u);
  EXPECT_EQ(actions.failed[0].needed_bytes, 1001u);
  EXPECT_EQ(actions.failed[0].free_bytes, 1000u);
  announce.version = 2;
  announce.index_bytes = 100;
  ASSERT_TRUE(receiver.announce(announce, actions).is_ok());
  EXPECT_EQ(actions.need.size(), 1u);
}

TEST(SceneReceiver, AWrongDigestFailsTheVersionAndTheNextIsServed) {
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_texts(1, {"good", "x"}), actions).is_ok());
  ASSERT_TRUE(receiver.announce(announce_texts(2, {"good", "x"}), actions).is_ok());
  EXPECT_TRUE(receiver.chunk(whole(1, 0, "evil"), actions).is_ok());
  ASSERT_EQ(actions.failed.size(), 1u);
  EXPECT_EQ(actions.failed[0].version, 1u);
  EXPECT_TRUE(actions.complete.empty());
  ASSERT_EQ(actions.need.size(), 2u);
  EXPECT_EQ(actions.need[1].blocks, (std::vector<std::uint32_t>{0, 1}))
      << "the bad bytes are not kept";
}

TEST(SceneReceiver, AnAnnouncedSizeThatDoesNotFitTheKnownBlockFails) {
  SceneReceiver receiver;
  Actions actions;
  SceneAnnounce lying = announce_texts(1, {"same", "same"});
  lying.sizes[1] = 5;
  ASSERT_TRUE(receiver.announce(lying, actions).is_ok());
  EXPECT_TRUE(receiver.chunk(whole(1, 0, "same"), actions).is_ok());
  EXPECT_TRUE(actions.complete.empty());
  EXPECT_EQ(actions.failed.size(), 1u);
}

// A block that is here may be said to have any size: nothing is told of chunks that it has not, and
// nothing is asked for.
TEST(SceneReceiver, AKeptBlockIsNoLargerThanItIs) {
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_texts(1, {"same"}), actions).is_ok());
  ASSERT_TRUE(receiver.chunk(whole(1, 0, "same"), actions).is_ok());
  ASSERT_EQ(actions.complete.size(), 1u);
  SceneAnnounce lying = announce_texts(2, {"same", "same", "other"});
  lying.sizes[0] = lying.sizes[1] = kSceneBlockBytesMax;
  actions = {};
  ASSERT_TRUE(receiver.announce(lying, actions).is_ok());
  ASSERT_EQ(actions.failed.size(), 1u);
  EXPECT_NE(actions.failed[0].reason.find("announced size"), std::string::npos);
  EXPECT_TRUE(actions.arrived.empty());
  EXPECT_TRUE(actions.need.empty());
}

TEST(SceneReceiver, AKeptBlockIsThereAsSoonAsItsVersionHasBegun) {
  const Bytes block = large(5, 1);
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {block}), actions).is_ok());
  ASSERT_EQ(serve(receiver, actions, {block}), 5u);
  actions = {};
  ASSERT_TRUE(receiver.announce(announce_of(2, {block, block}), actions).is_ok());
  EXPECT_EQ(actions.begun, std::vector<SceneVersion>{2});
  EXPECT_TRUE(actions.arrived.empty()) << "its chunks are found, and need not be named";
  net::SharedBytes held;
  for (std::uint32_t i = 0; i < 10; ++i)
    EXPECT_EQ(receiver.find(2, i / 5, i % 5, held), SceneReceiver::Holding::kHere);
}

// A number near the largest one must not wrap around to a small sum.
TEST(SceneReceiver, AnIndexOfAnySizeIsCounted) {
  SceneReceiver receiver([](std::uint64_t) { return std::optional<std::uint64_t>(1u << 20); });
  Actions actions;
  SceneAnnounce announce = announce_texts(1, {"one"});
  announce.index_bytes = ~std::uint64_t{0};
  ASSERT_TRUE(receiver.announce(announce, actions).is_ok());
  ASSERT_EQ(actions.failed.size(), 1u);
  EXPECT_EQ(actions.failed[0].needed_bytes, ~std::uint64_t{0});
}

TEST(SceneReceiver, BreachesAreFound) {
  const auto breach = [](const SceneChunk& chunk) {
    SceneReceiver receiver;
    Actions actions;
    EXPECT_TRUE(
        receiver.announce(announce_of(3, {bytes_of("four"), large(2, 1)}), actions).is_ok());
    return !receiver.chunk(chunk, actions).is_ok();
  };
  EXPECT_FALSE(breach(whole(3, 0, "four")));
  EXPECT_TRUE(breach(whole(4, 0, "four"))) << "a version never announced";
  EXPECT_TRUE(breach(whole(3, 2, "x"))) << "no such block";
  EXPECT_TRUE(breach(piece(3, 0, 1, bytes_of("our")))) << "not at a chunk";
  EXPECT_TRUE(breach(whole(3, 0, "fou"))) << "shorter than announced";
  EXPECT_TRUE(breach(whole(3, 0, "fourx"))) << "longer than announced";
  EXPECT_TRUE(breach(chunk_of(3, 1, large(2, 1), 0))) << "before its list";
  SceneReceiver receiver;
  Actions actions;
  EXPECT_TRUE(receiver.announce(announce_texts(3, {"a", "b"}), actions).is_ok());
  EXPECT_FALSE(receiver.announce(announce_texts(3, {"b", "c"}), actions).is_ok())
      << "goes backwards";
  EXPECT_FALSE(receiver.list(list_of(3, 0, large(2, 1)), actions).is_ok()) << "has one chunk";
  EXPECT_FALSE(receiver.chunk(whole(4, 0, "a"), actions).is_ok()) << "not asked for";
}

TEST(SceneReceiver, AnnouncementsAreBounded) {
  SceneReceiver receiver;
  Actions actions;
  SceneVersion version = 1;
  while (
      receiver.announce(announce_texts(version, {std::to_string(version), "x"}), actions).is_ok()) {
    ASSERT_LT(++version, 100u);
  }
  EXPECT_EQ(version, SceneReceiver::kAnnouncedMax + 2);  // one is being served
}

}  // namespace
}  // namespace tessera::wire
