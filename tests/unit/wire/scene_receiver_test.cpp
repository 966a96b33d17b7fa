// Scene pieces in, complete scenes out; a sender that breaks the rules is found out.
#include "common/wire/scene_receiver.h"

#include <gtest/gtest.h>

namespace tessera::wire {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

SceneAnnounce announce_of(SceneVersion version, const std::vector<std::string>& blocks) {
  SceneAnnounce a;
  a.version = version;
  for (const std::string& block : blocks) {
    a.digests.push_back(sha256(bytes_of(block)));
    a.sizes.push_back(block.size());
  }
  return a;
}

SceneChunk piece(SceneVersion version, std::uint32_t block, std::uint64_t offset,
                 const std::string& text) {
  return {version, block, offset, net::SharedBytes::of(bytes_of(text))};
}

using Actions = SceneReceiver::Actions;

TEST(SceneReceiver, BlocksMayInterleaveAndEqualOnesAreAskedForOnce) {
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {"root", "mesh", "mesh"}), actions).is_ok());
  ASSERT_EQ(actions.need.size(), 1u);
  EXPECT_EQ(actions.need[0].blocks, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_TRUE(receiver.chunk(piece(1, 1, 0, "me"), actions).is_ok());
  EXPECT_TRUE(receiver.chunk(piece(1, 0, 0, "root"), actions).is_ok());
  EXPECT_TRUE(actions.complete.empty());
  EXPECT_TRUE(receiver.chunk(piece(1, 1, 2, "sh"), actions).is_ok());
  ASSERT_EQ(actions.complete.size(), 1u);
  const EncodedScene& scene = actions.complete[0].scene;
  ASSERT_EQ(scene.blocks.size(), 3u);
  EXPECT_EQ(*scene.blocks[2].bytes, bytes_of("mesh"));
  EXPECT_EQ(scene.blocks[1].bytes, scene.blocks[2].bytes) << "one copy";
}

TEST(SceneReceiver, KeepsTheBlocksOfTwoScenes) {
  SceneReceiver receiver;
  SceneVersion version = 0;
  const auto lacking = [&](const std::string& block) {
    Actions actions;
    ++version;
    EXPECT_TRUE(receiver.announce(announce_of(version, {block}), actions).is_ok());
    const bool is_lacking = !actions.need.at(0).blocks.empty();
    if (is_lacking) {
      EXPECT_TRUE(receiver.chunk(piece(version, 0, 0, block), actions).is_ok());
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
  ASSERT_TRUE(receiver.announce(announce_of(1, {"shared"}), actions).is_ok());
  ASSERT_TRUE(receiver.announce(announce_of(2, {"shared", "new"}), actions).is_ok());
  EXPECT_EQ(actions.need.size(), 1u);
  ASSERT_TRUE(receiver.chunk(piece(1, 0, 0, "shared"), actions).is_ok());
  ASSERT_EQ(actions.need.size(), 2u);
  EXPECT_EQ(actions.need[1].blocks, (std::vector<std::uint32_t>{1}));
}

TEST(SceneReceiver, ARetiredTransferMakesRoomAndItsLatePiecesAreIgnored) {
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {"long one"}), actions).is_ok());
  ASSERT_TRUE(receiver.announce(announce_of(2, {"b"}), actions).is_ok());
  ASSERT_TRUE(receiver.chunk(piece(1, 0, 0, "long"), actions).is_ok());
  receiver.retire(2, actions);
  ASSERT_EQ(actions.need.size(), 2u);
  EXPECT_EQ(actions.need[1].version, 2u);
  EXPECT_TRUE(receiver.chunk(piece(1, 0, 4, " one"), actions).is_ok());
  EXPECT_TRUE(receiver.chunk(piece(2, 0, 0, "b"), actions).is_ok());
  ASSERT_EQ(actions.complete.size(), 1u);
  EXPECT_EQ(actions.complete[0].version, 2u);
}

TEST(SceneReceiver, AWrongDigestFailsTheVersionAndTheNextIsServed) {
  SceneReceiver receiver;
  Actions actions;
  ASSERT_TRUE(receiver.announce(announce_of(1, {"good"}), actions).is_ok());
  ASSERT_TRUE(receiver.announce(announce_of(2, {"good"}), actions).is_ok());
  EXPECT_TRUE(receiver.chunk(piece(1, 0, 0, "evil"), actions).is_ok());
  ASSERT_EQ(actions.failed.size(), 1u);
  EXPECT_EQ(actions.failed[0].version, 1u);
  EXPECT_TRUE(actions.complete.empty());
  ASSERT_EQ(actions.need.size(), 2u);
  EXPECT_EQ(actions.need[1].blocks, (std::vector<std::uint32_t>{0}))
      << "the bad bytes are not kept";
}

TEST(SceneReceiver, AnAnnouncedSizeThatDoesNotFitTheKnownBlockFails) {
  SceneReceiver receiver;
  Actions actions;
  SceneAnnounce lying = announce_of(1, {"same", "same"});
  lying.sizes[1] = 5;
  ASSERT_TRUE(receiver.announce(lying, actions).is_ok());
  EXPECT_TRUE(receiver.chunk(piece(1, 0, 0, "same"), actions).is_ok());
  EXPECT_TRUE(actions.complete.empty());
  EXPECT_EQ(actions.failed.size(), 1u);
}

TEST(SceneReceiver, BreachesAreFound) {
  const auto breach = [](const SceneChunk& chunk) {
    SceneReceiver receiver;
    Actions actions;
    EXPECT_TRUE(receiver.announce(announce_of(3, {"four", "five5"}), actions).is_ok());
    EXPECT_TRUE(receiver.chunk(piece(3, 0, 0, "fo"), actions).is_ok());
    return !receiver.chunk(chunk, actions).is_ok();
  };
  EXPECT_FALSE(breach(piece(3, 0, 2, "ur")));
  EXPECT_TRUE(breach(piece(4, 0, 2, "ur"))) << "a version never announced";
  EXPECT_TRUE(breach(piece(3, 2, 0, "x"))) << "no such block";
  EXPECT_TRUE(breach(piece(3, 0, 1, "our"))) << "overlaps";
  EXPECT_TRUE(breach(piece(3, 0, 3, "r"))) << "leaves a gap";
  EXPECT_TRUE(breach(piece(3, 0, 2, "urx"))) << "longer than announced";
  SceneReceiver receiver;
  Actions actions;
  EXPECT_TRUE(receiver.announce(announce_of(3, {"a"}), actions).is_ok());
  EXPECT_FALSE(receiver.announce(announce_of(3, {"b"}), actions).is_ok()) << "goes backwards";
  EXPECT_TRUE(receiver.chunk(piece(3, 0, 0, "a"), actions).is_ok());
  EXPECT_FALSE(receiver.chunk(piece(4, 0, 0, "a"), actions).is_ok()) << "not asked for";
}

TEST(SceneReceiver, AnnouncementsAreBounded) {
  SceneReceiver receiver;
  Actions actions;
  SceneVersion version = 1;
  while (receiver.announce(announce_of(version, {std::to_string(version)}), actions).is_ok()) {
    ASSERT_LT(++version, 100u);
  }
  EXPECT_EQ(version, SceneReceiver::kAnnouncedMax + 2);  // one is being served
}

}  // namespace
}  // namespace tessera::wire
