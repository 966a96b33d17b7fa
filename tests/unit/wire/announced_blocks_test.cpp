// SPDX-License-Identifier: Apache-2.0
// Two ends of a connection agree on the blocks of each scene, and little is said of what stays.
#include "common/wire/announced_blocks.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "common/wire/codec.h"

namespace tessera::wire {
namespace {

struct Blocks {
  std::vector<Digest> digests;
  std::vector<std::uint64_t> sizes;

  void set(std::size_t block, std::uint8_t tag) {
    digests[block] = {};
    digests[block].bytes[0] = tag;
    sizes[block] = 1000u + tag;
  }
};

Blocks blocks_of(std::size_t count) {
  Blocks blocks{std::vector<Digest>(count), std::vector<std::uint64_t>(count)};
  for (std::size_t i = 0; i < count; ++i) blocks.set(i, static_cast<std::uint8_t>(i));
  return blocks;
}

Blocks listed(const BlockNames& names) {
  Blocks blocks;
  for (const BlockName& name : names) {
    blocks.digests.push_back(name.digest);
    blocks.sizes.push_back(name.size_bytes);
  }
  return blocks;
}

// Tables of blocks, each of which shares with the one before what has not changed.
class Describer {
 public:
  SceneAnnounce describe(const Blocks& blocks) {
    BlockTable::Editor table(table_);
    table.resize(blocks.digests.size());
    for (std::size_t i = 0; i < blocks.digests.size(); ++i) {
      if (table[i].bytes && table[i].digest == blocks.digests[i]) continue;
      table.edit(i) = {blocks.digests[i], block_bytes_of(std::vector<std::byte>(blocks.sizes[i])),
                       nullptr};
    }
    table_ = table.finish();
    SceneAnnounce announce;
    sender_.describe(table_, announce);
    return announce;
  }

 private:
  BlockTable table_;
  AnnouncedBlocks sender_;
};

TEST(AnnouncedBlocks, OnlyWhatDiffersIsNamed) {
  Describer sender;
  Blocks blocks = blocks_of(100);
  EXPECT_FALSE(sender.describe(blocks).is_again) << "nothing was announced before";
  EXPECT_TRUE(sender.describe(blocks).places.empty());
  blocks.set(0, 200);
  blocks.set(70, 201);
  const SceneAnnounce announce = sender.describe(blocks);
  EXPECT_TRUE(announce.is_again);
  EXPECT_EQ(announce.places, (std::vector<std::uint32_t>{0, 70}));
  EXPECT_EQ(announce.digests.size(), 2u);
  EXPECT_EQ(announce.sizes, (std::vector<std::uint64_t>{1200, 1201}));
}

TEST(AnnouncedBlocks, WhereMostDifferOrTheirNumberDoesAllAreNamed) {
  Describer sender;
  Blocks blocks = blocks_of(10);
  sender.describe(blocks);
  for (std::size_t i = 0; i < 6; ++i) blocks.set(i, 99);
  const SceneAnnounce most = sender.describe(blocks);
  EXPECT_FALSE(most.is_again);
  EXPECT_EQ(most.digests, blocks.digests);
  EXPECT_TRUE(most.places.empty());
  const Blocks fewer = blocks_of(9);
  EXPECT_EQ(sender.describe(fewer).digests, fewer.digests);
}

TEST(AnnouncedBlocks, BothEndsAgreeAfterAnyChanges) {
  std::mt19937 random(11);
  Describer sender;
  AnnouncedBlocks receiver;
  Blocks blocks = blocks_of(20);
  for (int version = 0; version < 2000; ++version) {
    if (random() % 16 == 0) blocks = blocks_of(1 + random() % 600);
    for (auto i = random() % 12; i > 0; --i)
      blocks.set(random() % blocks.digests.size(), static_cast<std::uint8_t>(random()));
    const SceneAnnounce announce = sender.describe(blocks);
    ASSERT_TRUE(receiver.take(announce).is_ok());
    ASSERT_EQ(listed(receiver.names()).digests, blocks.digests) << "version " << version;
    ASSERT_EQ(listed(receiver.names()).sizes, blocks.sizes) << "version " << version;
    ASSERT_EQ(receiver.total_bytes(),
              std::accumulate(blocks.sizes.begin(), blocks.sizes.end(), std::uint64_t{0}));
  }
}

TEST(AnnouncedBlocks, DifferencesFromNothingOrBeyondTheEndAreRefused) {
  Describer sender;
  AnnouncedBlocks receiver;
  SceneAnnounce first = sender.describe(blocks_of(4));
  SceneAnnounce again = sender.describe(blocks_of(4));
  EXPECT_EQ(receiver.take(again).code(), StatusCode::kDataLoss);
  ASSERT_TRUE(receiver.take(first).is_ok());
  SceneAnnounce beyond;
  beyond.is_again = true;
  beyond.places = {1, 4};
  beyond.digests.resize(2);
  beyond.sizes = {7, 7};
  EXPECT_EQ(receiver.take(beyond).code(), StatusCode::kDataLoss);
  ASSERT_TRUE(receiver.take(again).is_ok());
  EXPECT_EQ(listed(receiver.names()).digests, blocks_of(4).digests)
      << "what was refused has left nothing behind";
}

TEST(AnnouncedBlocks, PlacesThatDoNotRiseOrAreTooHighAreRefusedByName) {
  for (const std::vector<std::uint32_t>& places :
       {std::vector<std::uint32_t>{4, 4}, {4, 3}, {4, kSceneBlocksMax}, {4, 5}}) {
    SceneAnnounce announce;
    announce.version = 3;
    announce.is_again = true;
    announce.digests.resize(2);
    announce.sizes = {1, 1};
    announce.places = places;
    net::Record record = encode(std::move(announce));
    const auto decoded = decode(
        {record.type, record.header, {record.payload.bytes.begin(), record.payload.bytes.end()}});
    ASSERT_EQ(decoded.is_ok(), places.back() == 5);
    if (decoded.is_ok()) continue;
    EXPECT_NE(decoded.status().message().find("SceneAnnounce.places"), std::string::npos)
        << decoded.status().message();
  }
}

}  // namespace
}  // namespace tessera::wire
