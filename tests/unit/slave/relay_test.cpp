// SPDX-License-Identifier: Apache-2.0
// Slaves feed each other in virtual time, chunk by chunk while their own are still coming. A slave
// that lies, is silent, knocks without the token or asks for what nobody announced is found out.
#include <gtest/gtest.h>

#include <algorithm>

#include "common/wire/record_types.h"
#include "tests/unit/slave/relay_fixture.h"
#include "tests/unit/slave/relay_stranger.h"

namespace tessera::slave {
namespace {

using namespace std::chrono_literals;
using wire::RelayFault;

TEST_F(RelayTest, ChunksArePassedOnWhileOthersAreStillComing) {
  const auto upper = slave("upper"), lower = slave("lower");
  give(*upper, {2});
  lower->follow(kVersion, *upper);
  settle();
  EXPECT_EQ(lower->stored.size(), 1u) << "what was there";
  give(*upper, {5});
  settle();
  EXPECT_EQ(lower->stored.size(), 2u) << "as soon as it is there";
  give(*upper, {0, 1, 3, 4});
  settle();
  EXPECT_TRUE(lower->complete_at);
  EXPECT_EQ(faults(*lower), kNone);
  EXPECT_EQ(chunks_sent_["upper"], kChunks) << "each once";
}

// A chunk takes its time on the uplink of each slave, and a segment its time on the downlink. So
// the last of a chain is complete a chunk and a segment later than the one above it, where passing
// on whole blocks would take another block's time.
TEST_F(RelayTest, AChainTakesAChunkLongerForEachOfItsLinks) {
  const double rate = 1e6;
  const sim::LinkModel link{rate, rate, 1ms, 0ms};
  const auto head = slave("head"), middle = slave("middle", link), last = slave("last", link);
  give_all(*head);
  last->follow(kVersion, *middle);
  run_for(100ms);  // its needs are there before the middle one's link is full
  middle->follow(kVersion, *head);
  settle();
  ASSERT_TRUE(middle->complete_at && last->complete_at);
  EXPECT_LT(last->stored.front().second, middle->stored.back().second);
  EXPECT_GT(*last->complete_at, *middle->complete_at);
  EXPECT_LT(seconds(*last->complete_at - *middle->complete_at), 2 * kSceneChunkBytes / rate);
  EXPECT_EQ(chunks_sent_["head"], kChunks);
  EXPECT_EQ(chunks_sent_["middle"], kChunks);
}

// The next version is asked for before its announcement is at the feeder, which has most of it
// already; the connection of the first serves, though the time for handshakes is over.
TEST_F(RelayTest, TheNextVersionComesOverTheSameConnectionHoweverEarlyItIsAskedFor) {
  const auto upper = slave("upper"), lower = slave("lower");
  lower->follow(kVersion, *upper);
  give_all(*upper);
  run_for(2 * std::chrono::milliseconds(kHandshakeMs));
  ASSERT_TRUE(lower->complete_at);
  lower->complete_at.reset();
  Bytes next = noise(kChunks + 1);  // what is known above is not known below
  std::reverse(next.begin(), next.end());
  upper->announce(kVersion + 1, next);
  for (std::uint32_t i = 0; i < kChunks + 1; ++i) upper->give(kVersion + 1, next, i);
  Bytes third = next;
  third[0] ^= std::byte{1};
  lower->announce(kVersion + 2, third);
  lower->follow(kVersion + 2, *upper);
  lower->stored.clear();
  settle();
  EXPECT_TRUE(lower->stored.empty()) << "it is not announced above";
  upper->announce(kVersion + 2, third);
  settle();
  EXPECT_EQ(lower->stored.size(), kChunks) << "what was known above";
  upper->give(kVersion + 2, third, 0);
  settle();
  EXPECT_TRUE(lower->complete_at);
  EXPECT_EQ(faults(*lower), kNone);
  EXPECT_EQ(lower->connects, 1);
}

TEST_F(RelayTest, WhoGoesWhileNothingIsWantedIsNoFault) {
  const auto upper = slave("upper"), lower = slave("lower");
  lower->follow(kVersion, *upper);
  give_all(*upper);
  settle();
  ASSERT_TRUE(lower->complete_at);
  upper->feeder().drop_all();
  settle();
  EXPECT_EQ(faults(*lower), kNone);
}

TEST_F(RelayTest, OneThatGoesAwayIsReported) {
  const auto upper = slave("upper"), lower = slave("lower");
  lower->follow(kVersion, *upper);
  give(*upper, {0});
  settle();
  EXPECT_EQ(lower->stored.size(), 1u);
  upper->feeder().drop_all();
  settle();
  EXPECT_EQ(faults(*lower), kOnceGone);
}

// Of 40 chunks some are queued and some on their way when the feeder's process ends. What has come
// stays, and the next feeder is asked for the rest alone.
TEST_F(RelayTest, AFeederThatEndsWithChunksInItsQueueIsReportedOnceAndWhatCameStays) {
  block_ = noise(40);
  const auto upper = slave("upper", {1e6, 1e6, 1ms, 0ms});
  const auto lower = slave("lower"), other = slave("other");
  give_all(*upper);
  give_all(*other);
  lower->follow(kVersion, *upper);
  run_for(500ms);
  upper->end(false);
  settle();
  EXPECT_EQ(faults(*lower), kOnceGone);
  const auto came = static_cast<std::uint32_t>(lower->stored.size());
  EXPECT_GT(came, 0u);
  EXPECT_LT(came, chunks_sent_["upper"]) << "chunks were queued";
  lower->follow(kVersion, *other);
  settle();
  EXPECT_TRUE(lower->complete_at);
  EXPECT_EQ(lower->stored.size(), 40u) << "each once";
  EXPECT_EQ(chunks_sent_["other"], 40 - came);
}

// Whether a feeder is too slow is for the master to say. When it has, the feeder left behind is
// heard no more, even if its chunks are on their way.
TEST_F(RelayTest, AFeederLeftForAnotherIsHeardNoMore) {
  const auto slow = slave("slow", {0, 0, 5ms, 0ms});
  const auto other = slave("other"), lower = slave("lower");
  give_all(*slow);
  give(*other, {0});
  lower->follow(kVersion, *slow);
  run_for(17ms);  // two delays to connect, one to ask
  EXPECT_EQ(chunks_sent_["slow"], kChunks);
  EXPECT_TRUE(lower->stored.empty());
  lower->follow(kVersion, *other);
  settle();
  EXPECT_EQ(lower->stored.size(), 1u) << "the other one has no more";
  EXPECT_EQ(faults(*lower), kNone);
  EXPECT_EQ(slow->feeder().child_count(), 0u) << "its child is gone";
  EXPECT_EQ(other->feeder().child_count(), 1u);
}

TEST_F(RelayTest, AFeederThatCannotBeReachedIsReported) {
  const auto nobody = slave("nobody"), far = slave("far"), lower = slave("lower");
  nobody->end(false);
  lower->follow(kVersion, *nobody);
  settle();
  EXPECT_EQ(faults(*lower), std::vector{RelayFault::kUnreachable});
  network_.cut(lower->node(), far->node());
  lower->follow(kVersion, *far);
  settle();
  ASSERT_EQ(faults(*lower), (std::vector{RelayFault::kUnreachable, RelayFault::kUnreachable}));
  EXPECT_EQ(lower->failures.back().feeder, RelaySlave::word(kVersion, far->node()).feeder);
}

// A factory may answer before it returns; nothing is reported from inside a call of ours.
TEST_F(RelayTest, AnAnswerFromInsideTheCallIsTakenLater) {
  const auto lower = slave("lower"), upper = slave("upper");
  lower->access().connect = [](const net::Endpoint&, const auto& on_connected) {
    on_connected(Status::unavailable("no route"));
    return std::unique_ptr<net::ConnectAttempt>();
  };
  lower->follow(kVersion, *upper);
  EXPECT_EQ(faults(*lower), kNone);
  settle();
  EXPECT_EQ(faults(*lower), std::vector{RelayFault::kUnreachable});
}

TEST_F(RelayTest, AWrongTokenIsTurnedAway) {
  const auto upper = slave("upper"), lower = slave("lower");
  give(*upper, {0});
  lower->follow(kVersion, *upper, RelaySlave::kToken + 1);
  settle();
  ASSERT_EQ(faults(*lower), kOnceGone);
  EXPECT_EQ(lower->failures[0].reason, "it refuses: a wrong token");
  EXPECT_TRUE(lower->stored.empty());
  EXPECT_EQ(upper->feeder().child_count(), 0u);
}

TEST_F(RelayTest, AVersionThatIsNotKeptIsRefused) {
  const auto upper = slave("upper"), lower = slave("lower");
  lower->child().follow(RelaySlave::word(kVersion, upper->node()), {need_of(kVersion - 1, 1)});
  settle();
  EXPECT_EQ(faults(*lower), kOnceGone);
}

TEST_F(RelayTest, AChunkBeyondTheBlockIsRefused) {
  const auto upper = slave("upper"), lower = slave("lower");
  lower->child().follow(RelaySlave::word(kVersion, upper->node()), {need_of(kVersion, 7)});
  settle();
  EXPECT_EQ(faults(*lower), kOnceGone);
}

void expect_refused(const RelayStranger& stranger, const std::string& reason) {
  EXPECT_TRUE(stranger.closed_at);
  ASSERT_EQ(stranger.heard.size(), 1u);
  const auto* refuse = std::get_if<wire::Refuse>(&stranger.heard[0]);
  ASSERT_NE(refuse, nullptr);
  EXPECT_EQ(refuse->reason, reason);
}

// The lists of what it wants are bounded, too: 128 blocks of the largest size, 2 MiB.
TEST_F(RelayTest, WhoAsksForMoreChunksThanAnySceneHasIsSentAway) {
  const auto upper = slave("upper");
  RelayStranger stranger(queue_, network_);
  stranger.call(upper->node());
  stranger.say(wire::RelayJoin{RelaySlave::kToken, wire::kByteCodingsNone});
  for (std::uint32_t i = 0; i < 128; ++i)
    stranger.say(need_of(kVersion + 1, kSceneBlockChunksMax, i));
  for (std::uint32_t i = 0; i < 128; ++i)  // the same once more is nothing more
    stranger.say(need_of(kVersion + 1, kSceneBlockChunksMax, i));
  settle();
  EXPECT_FALSE(stranger.closed_at);
  stranger.say(need_of(kVersion + 1, 1, 128));
  settle();
  expect_refused(stranger, "it asks for too much at once");
}

TEST_F(RelayTest, AnAlteredChunkEndsItWithThatReason) {
  const auto lower = slave("lower");
  RelayStranger liar(queue_, network_);
  Bytes altered = block_;
  altered[100] ^= std::byte{1};
  liar.wait_for_child(chunk_of(kVersion, altered, 0));
  lower->child().follow(RelaySlave::word(kVersion, liar.node()), {need_of(kVersion, kChunks)});
  settle();
  EXPECT_EQ(faults(*lower), std::vector{RelayFault::kAltered});
  EXPECT_TRUE(lower->stored.empty());
  EXPECT_TRUE(liar.closed_at);
}

// The master bars who altered a chunk from feeding anybody, and whom memory fails is another slave.
TEST_F(RelayTest, MemoryThatRunsOutBlamesNoFeeder) {
  const auto upper = slave("upper"), lower = slave("lower");
  give(*upper, {0, 1});
  lower->is_out_of_memory = true;
  lower->follow(kVersion, *upper);
  settle();
  EXPECT_EQ(faults(*lower), kOnceGone);
  ASSERT_FALSE(lower->failures.empty());
  EXPECT_EQ(lower->failures[0].reason, "no memory here for block 0, offset 0");
  EXPECT_TRUE(lower->stored.empty());
}

TEST_F(RelayTest, WhoNeverSaysTheTokenIsSentAwayInTime) {
  const auto upper = slave("upper");
  give_all(*upper);
  RelayStranger stranger(queue_, network_);
  const TimePoint began = queue_.now();
  stranger.call(upper->node());
  run_for(1s);
  EXPECT_EQ(upper->feeder().child_count(), 1u);
  settle();
  ASSERT_TRUE(stranger.closed_at);
  EXPECT_EQ(*stranger.closed_at - began, std::chrono::milliseconds(kHandshakeMs));
  EXPECT_EQ(upper->feeder().child_count(), 0u);
  EXPECT_TRUE(stranger.heard.empty());
}

TEST_F(RelayTest, WhoAsksBeforeItSaysTheTokenGetsNothing) {
  const auto upper = slave("upper");
  give_all(*upper);
  RelayStranger stranger(queue_, network_);
  stranger.call(upper->node());
  stranger.say(need_of(kVersion, kChunks));
  run_for(1s);
  EXPECT_TRUE(stranger.closed_at);
  EXPECT_TRUE(stranger.heard.empty());
  EXPECT_EQ(upper->feeder().child_count(), 0u);
}

// Needs of a version that may be on its way are kept: one for each block of the largest scene.
TEST_F(RelayTest, WhoAsksForMoreBlocksThanASceneHasIsSentAway) {
  const auto upper = slave("upper");
  RelayStranger stranger(queue_, network_);
  stranger.call(upper->node());
  stranger.say(wire::RelayJoin{RelaySlave::kToken, wire::kByteCodingsNone});
  for (std::uint32_t i = 0; i < kSceneBlocksMax; ++i) stranger.say(need_of(kVersion + 1, 1, i));
  settle();
  EXPECT_FALSE(stranger.closed_at);
  stranger.say(need_of(kVersion + 1, 1, kSceneBlocksMax - 1));
  settle();
  expect_refused(stranger, "it asks for too much at once");
}

// A child that does not read costs its feeder the low mark, a chunk and its head, whatever it has
// asked for.
TEST_F(RelayTest, WhatIsQueuedForAChildIsBounded) {
  block_ = noise(40);
  const auto upper = slave("upper"), lower = slave("lower");
  give_all(*upper);
  lower->follow(kVersion, *upper);
  run_for(100us);  // what is asked for is on its way
  lower->process().set_hung(true);
  run_for(60s);
  EXPECT_GT(queued_max_, net::kSendQueueLowBytes);
  EXPECT_LE(queued_max_, net::kSendQueueLowBytes + kSceneChunkBytes + wire::kSmallHeaderBytesMax);
  lower->process().set_hung(false);
  settle();
  EXPECT_TRUE(lower->complete_at);
}

// A child that asks for the same chunks again and again and does not read gets each at most once
// more than what was queued when it stopped; its feeder remembers what, and not how often.
TEST_F(RelayTest, WhatIsAskedForAgainWaitsOnce) {
  constexpr std::uint32_t kMany = 40;
  block_ = noise(kMany);
  const auto upper = slave("upper", {0, 0, 5ms, 0ms});
  give_all(*upper);
  RelayStranger stranger(queue_, network_);
  stranger.call(upper->node());
  stranger.say(wire::RelayJoin{RelaySlave::kToken, wire::kByteCodingsNone});
  for (int i = 0; i < 20; ++i) stranger.say(need_of(kVersion, kMany));
  run_for(12ms);  // two delays to connect; what it says is on its way
  stranger.process().set_hung(true);
  run_for(10s);
  const std::uint32_t queued = chunks_sent_["upper"];
  EXPECT_LT(queued, kMany);
  stranger.process().set_hung(false);
  settle();
  EXPECT_GE(stranger.heard.size(), kMany);
  EXPECT_LE(stranger.heard.size(), queued + kMany);
}

}  // namespace
}  // namespace tessera::slave
