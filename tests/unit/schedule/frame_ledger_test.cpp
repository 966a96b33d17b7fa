#include "master/schedule/frame_ledger.h"

#include <gtest/gtest.h>

#include <set>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;
constexpr SceneVersion kVersion = 7;
const TimePoint kStart{};

TEST(FrameLedger, EveryTileIsLeasedOnceInOrderAndThenTheFrameIsComplete) {
  FrameLedger ledger(kVersion, 3);
  for (TileIndex tile = 0; tile < 3; ++tile) {
    const auto lease = ledger.lease_next(1, kStart);
    ASSERT_TRUE(lease.has_value());
    EXPECT_EQ(lease->tile, tile);
    EXPECT_FALSE(ledger.is_complete());
    EXPECT_EQ(ledger.accept(1, kVersion, tile, lease->attempt), ResultVerdict::kAccepted);
  }
  EXPECT_FALSE(ledger.lease_next(1, kStart).has_value());
  EXPECT_TRUE(ledger.is_complete());
  EXPECT_EQ(ledger.reissued_count(), 0u);
}

TEST(FrameLedger, OnlyTheAnswerToAnOutstandingLeaseIsAccepted) {
  FrameLedger ledger(kVersion, 2);
  const TileAssignment lease = *ledger.lease_next(1, kStart);
  EXPECT_EQ(ledger.accept(2, kVersion, lease.tile, lease.attempt), ResultVerdict::kNotLeased);
  EXPECT_EQ(ledger.accept(1, kVersion, lease.tile, lease.attempt + 1), ResultVerdict::kNotLeased);
  EXPECT_EQ(ledger.accept(1, kVersion + 1, lease.tile, lease.attempt),
            ResultVerdict::kWrongVersion);
  EXPECT_EQ(ledger.accept(1, kVersion, 1, 1), ResultVerdict::kNotLeased);
  EXPECT_EQ(ledger.accept(1, kVersion, 99, 1), ResultVerdict::kNotLeased);
  EXPECT_EQ(ledger.counts().accepted, 0u);
  EXPECT_EQ(ledger.accept(1, kVersion, lease.tile, lease.attempt), ResultVerdict::kAccepted);
  EXPECT_EQ(ledger.accept(1, kVersion, lease.tile, lease.attempt), ResultVerdict::kNotLeased)
      << "the same result twice";
}

TEST(FrameLedger, TilesOfALostSlaveComeFirstWithANewAttempt) {
  FrameLedger ledger(kVersion, 4);
  const TileAssignment first = *ledger.lease_next(1, kStart);
  const TileAssignment second = *ledger.lease_next(1, kStart);
  EXPECT_EQ(ledger.lose_session(1, 1), 1) << "one of its tiles may have been in rendering";
  EXPECT_EQ(ledger.accept(1, kVersion, first.tile, first.attempt), ResultVerdict::kNotLeased);
  const TileAssignment again = *ledger.lease_next(2, kStart), next = *ledger.lease_next(2, kStart);
  EXPECT_EQ((std::set<TileIndex>{again.tile, next.tile}),
            (std::set<TileIndex>{first.tile, second.tile}));
  EXPECT_GT(again.attempt, first.attempt);
  EXPECT_EQ(ledger.reissued_count(), 2u);
}

TEST(FrameLedger, AnOverdueTileIsLeasedASecondTimeAndTheFirstResultWins) {
  FrameLedger ledger(kVersion, 1);
  const TileAssignment slow = *ledger.lease_next(1, kStart);
  EXPECT_FALSE(ledger.lease_again(2, kStart + 99ms, 100ms).has_value()) << "not overdue yet";
  EXPECT_FALSE(ledger.lease_again(1, kStart + 1s, 100ms).has_value()) << "it has it already";
  const auto spare = ledger.lease_again(2, kStart + 1s, 100ms);
  ASSERT_TRUE(spare.has_value());
  EXPECT_FALSE(ledger.lease_again(3, kStart + 9s, 100ms).has_value()) << "two at most";
  EXPECT_EQ(ledger.accept(2, kVersion, 0, spare->attempt), ResultVerdict::kAccepted);
  EXPECT_EQ(ledger.accept(1, kVersion, 0, slow.attempt), ResultVerdict::kDuplicate);
  EXPECT_TRUE(ledger.is_complete());
  EXPECT_EQ(ledger.counts().rejected, 1u);
}

TEST(FrameLedger, LossesOfOneTileAreCounted) {
  FrameLedger ledger(kVersion, 1);
  for (int loss = 1; loss <= 3; ++loss) {
    ASSERT_TRUE(ledger.lease_next(static_cast<SessionId>(loss), kStart).has_value());
    EXPECT_EQ(ledger.lose_session(static_cast<SessionId>(loss), 1), loss);
  }
}

TEST(FrameLedger, WhatIsHandedBackIsPendingAgainAndNoLoss) {
  FrameLedger ledger(kVersion, 1);
  const TileAssignment lease = *ledger.lease_next(1, kStart);
  EXPECT_FALSE(ledger.hand_back(2, lease.tile, lease.attempt));
  EXPECT_TRUE(ledger.hand_back(1, lease.tile, lease.attempt));
  EXPECT_FALSE(ledger.hand_back(1, lease.tile, lease.attempt)) << "once";
  ASSERT_TRUE(ledger.lease_next(2, kStart).has_value());
  EXPECT_EQ(ledger.lose_session(2, 1), 1);
}

}  // namespace
}  // namespace tessera::master
