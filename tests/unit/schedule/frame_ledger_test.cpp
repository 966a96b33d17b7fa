// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/frame_ledger.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;
constexpr SceneVersion kVersion = 7;
const TimePoint kStart{};
const TimePoint kDue = kStart + 1s;

std::vector<TileIndex> tiles(TileIndex count) {
  std::vector<TileIndex> order(count);
  std::iota(order.begin(), order.end(), TileIndex{0});
  return order;
}

TEST(FrameLedger, EveryTileIsLeasedOnceInOrderAndThenTheFrameIsComplete) {
  FrameLedger ledger(kVersion, tiles(3));
  for (TileIndex tile = 0; tile < 3; ++tile) {
    const auto lease = ledger.lease_next(1, kStart, kDue);
    ASSERT_TRUE(lease.has_value());
    EXPECT_EQ(lease->tile, tile);
    EXPECT_FALSE(ledger.is_complete());
    EXPECT_EQ(ledger.accept(1, kVersion, tile, lease->attempt).verdict, ResultVerdict::kAccepted);
  }
  EXPECT_FALSE(ledger.lease_next(1, kStart, kDue).has_value());
  EXPECT_TRUE(ledger.is_complete());
}

TEST(FrameLedger, OnlyTheAnswerToAnOutstandingLeaseIsAccepted) {
  FrameLedger ledger(kVersion, tiles(2));
  const TileAssignment lease = *ledger.lease_next(1, kStart, kDue);
  EXPECT_EQ(ledger.accept(2, kVersion, lease.tile, lease.attempt).verdict,
            ResultVerdict::kNotLeased);
  EXPECT_EQ(ledger.accept(1, kVersion, lease.tile, lease.attempt + 1).verdict,
            ResultVerdict::kNotLeased);
  EXPECT_EQ(ledger.accept(1, kVersion + 1, lease.tile, lease.attempt).verdict,
            ResultVerdict::kWrongVersion);
  EXPECT_EQ(ledger.accept(1, kVersion, 1, 1).verdict, ResultVerdict::kNotLeased);
  EXPECT_EQ(ledger.accept(1, kVersion, 99, 1).verdict, ResultVerdict::kNotLeased);
  EXPECT_EQ(ledger.counts().accepted, 0u);
  EXPECT_EQ(ledger.accept(1, kVersion, lease.tile, lease.attempt).verdict,
            ResultVerdict::kAccepted);
  EXPECT_EQ(ledger.accept(1, kVersion, lease.tile, lease.attempt).verdict, ResultVerdict::kRepeated)
      << "the same result twice";
}

TEST(FrameLedger, TilesOfALostSlaveComeFirstWithANewAttempt) {
  FrameLedger ledger(kVersion, tiles(4));
  const TileAssignment first = *ledger.lease_next(1, kStart, kDue);
  const TileAssignment second = *ledger.lease_next(1, kStart, kDue);
  EXPECT_EQ(ledger.lose_session(1, {"a", "", 5}, true, kStart), second.tile);
  EXPECT_EQ(ledger.losses().tiles().size(), 2u) << "either may have been in rendering";
  EXPECT_EQ(ledger.accept(1, kVersion, first.tile, first.attempt).verdict,
            ResultVerdict::kNotLeased);
  const TileAssignment again = *ledger.lease_next(2, kStart, kDue),
                       next = *ledger.lease_next(2, kStart, kDue);
  EXPECT_EQ((std::set<TileIndex>{again.tile, next.tile}),
            (std::set<TileIndex>{first.tile, second.tile}));
  EXPECT_GT(again.attempt, first.attempt);
  EXPECT_FALSE(again.is_duplicate || next.is_duplicate) << "they were lost, not doubled";
}

TEST(FrameLedger, ATileIsLeasedASecondTimeAndTheFirstResultWins) {
  FrameLedger ledger(kVersion, tiles(1));
  const TileAssignment slow = *ledger.lease_next(1, kStart, kDue);
  ASSERT_EQ(ledger.single_leases().size(), 1u);
  EXPECT_EQ(ledger.single_leases()[0].due, kDue);
  EXPECT_FALSE(ledger.lease_again(0, 1, kStart, kDue).has_value()) << "it has it already";
  const auto spare = ledger.lease_again(0, 2, kStart, kDue);
  ASSERT_TRUE(spare.has_value());
  EXPECT_TRUE(spare->is_duplicate);
  EXPECT_TRUE(ledger.single_leases().empty());
  EXPECT_FALSE(ledger.lease_again(0, 3, kStart, kDue).has_value()) << "two at most";
  EXPECT_EQ(ledger.accept(2, kVersion, 0, spare->attempt).verdict, ResultVerdict::kAccepted);
  EXPECT_EQ(ledger.accept(1, kVersion, 0, slow.attempt).verdict, ResultVerdict::kDuplicate);
  EXPECT_TRUE(ledger.is_complete());
  EXPECT_EQ(ledger.counts().rejected, 1u);
}

TEST(FrameLedger, ATileThatIsOutWithStalledSlavesAloneIsLeasedOnceMore) {
  FrameLedger ledger(kVersion, tiles(1));
  ASSERT_TRUE(ledger.lease_next(1, kStart, kDue).has_value());
  ASSERT_TRUE(ledger.lease_again(0, 2, kStart, kDue).has_value());
  EXPECT_TRUE(ledger.single_leases().empty());
  const std::set<SessionId> stalled{1, 2};
  ASSERT_EQ(ledger.single_leases(stalled).size(), 1u);
  ASSERT_TRUE(ledger.lease_again(0, 3, kStart, kDue, stalled).has_value());
  EXPECT_EQ(ledger.single_leases(stalled)[0].session, 3u);
  ASSERT_TRUE(ledger.lease_again(0, 4, kStart, kDue, stalled).has_value());
  EXPECT_FALSE(ledger.lease_again(0, 5, kStart, kDue, {1, 2, 3, 4}).has_value()) << "at the bound";
}

TEST(FrameLedger, ASuspectTileGoesToAnotherSlaveOnceAndIsThenTakenAsItIs) {
  FrameLedger ledger(kVersion, tiles(1));
  const TileAssignment first = *ledger.lease_next(1, kStart, kDue);
  EXPECT_EQ(ledger.accept(1, kVersion, 0, first.attempt, 0, true).verdict, ResultVerdict::kFaulty);
  EXPECT_FALSE(ledger.is_complete());
  EXPECT_FALSE(ledger.next_for(1).has_value()) << "not the same slave again";
  const TileAssignment second = *ledger.lease_next(2, kStart, kDue);
  EXPECT_EQ(ledger.accept(2, kVersion, 0, second.attempt, 0, true).verdict,
            ResultVerdict::kAccepted);
  EXPECT_TRUE(ledger.is_complete());
  EXPECT_EQ(ledger.counts().rejected, 1u);
}

TEST(FrameLedger, ASuspectTileComesBackToItsSlaveWhenNobodyElseIsLeft) {
  FrameLedger ledger(kVersion, tiles(1));
  const TileAssignment first = *ledger.lease_next(1, kStart, kDue);
  EXPECT_EQ(ledger.accept(1, kVersion, 0, first.attempt, 0, true).verdict, ResultVerdict::kFaulty);
  ledger.waive_refusals(1);
  const TileAssignment again = *ledger.lease_next(1, kStart, kDue);
  EXPECT_EQ(ledger.accept(1, kVersion, 0, again.attempt, 0, false).verdict,
            ResultVerdict::kAccepted);
}

// An audited tile leased to slaves 1 and 2.
class AuditedTile : public ::testing::Test {
 protected:
  AuditedTile() {
    first_ = *ledger_.lease_next(1, kStart, kDue, true);
    EXPECT_FALSE(ledger_.next_for(1).has_value()) << "one slave does not audit itself";
    second_ = *ledger_.lease_next(2, kStart, kDue);
    EXPECT_FALSE(ledger_.next_for(3).has_value()) << "two are enough while they agree";
  }
  LedgerAnswer answer(SessionId session, const TileAssignment& lease, std::uint64_t pixels) {
    return ledger_.accept(session, kVersion, lease.tile, lease.attempt, pixels);
  }
  FrameLedger ledger_{kVersion, tiles(1)};
  TileAssignment first_, second_;
};

TEST_F(AuditedTile, IsDoneWhenTwoSlavesAgree) {
  EXPECT_EQ(answer(2, second_, 77).verdict, ResultVerdict::kAccepted);
  EXPECT_FALSE(ledger_.is_complete());
  EXPECT_EQ(answer(1, first_, 77).verdict, ResultVerdict::kConfirmed);
  EXPECT_TRUE(ledger_.is_complete());
}

TEST_F(AuditedTile, TheThirdSlaveOutvotesTheOneThatWasWrong) {
  EXPECT_EQ(answer(1, first_, 66).verdict, ResultVerdict::kAccepted);
  EXPECT_EQ(answer(2, second_, 77).verdict, ResultVerdict::kDisputed);
  const TileAssignment third = *ledger_.lease_next(3, kStart, kDue);
  const LedgerAnswer decided = answer(3, third, 77);
  EXPECT_EQ(decided.verdict, ResultVerdict::kAccepted) << "the first one's pixels are replaced";
  EXPECT_EQ(decided.outvoted.session, 1u);
  EXPECT_TRUE(ledger_.is_complete());
  EXPECT_EQ(ledger_.counts().accepted, 1u);
  EXPECT_EQ(ledger_.counts().rejected, 2u);
}

TEST_F(AuditedTile, ADisputeThatNobodyIsLeftToDecideIsNamed) {
  answer(1, first_, 66);
  EXPECT_FALSE(ledger_.waive_audits({1, 2}).has_value()) << "the second is still at work";
  answer(2, second_, 77);
  EXPECT_FALSE(ledger_.waive_audits({1, 2, 3}).has_value()) << "the third may decide";
  const auto dispute = ledger_.waive_audits({1, 2});
  ASSERT_TRUE(dispute.has_value());
  EXPECT_EQ(std::pair(dispute->first.session, dispute->second.session),
            (std::pair<SessionId, SessionId>{1, 2}));
}

TEST_F(AuditedTile, IsTakenAsItIsWhenTheAuditorsAreGone) {
  answer(1, first_, 66);
  ledger_.lose_session(2, {"b", "", 0}, true, kStart);
  EXPECT_FALSE(ledger_.waive_audits({1}).has_value());
  EXPECT_TRUE(ledger_.is_complete());
}

TEST_F(AuditedTile, IsPendingAgainWhenBothAreLost) {
  ledger_.lose_session(1, {"a", "", 0}, true, kStart);
  EXPECT_EQ(ledger_.lease_next(3, kStart, kDue)->tile, 0u) << "in the place of the first one";
  ledger_.lose_session(3, {"c", "", 0}, true, kStart);
  ledger_.lose_session(2, {"b", "", 0}, true, kStart);
  EXPECT_EQ(ledger_.pending_count(), 1u);
}

TEST(FrameLedger, OnlyTilesThatAreNotDoneAreLost) {
  FrameLedger ledger(kVersion, tiles(3));
  ASSERT_TRUE(ledger.lease_next(1, kStart, kDue).has_value());
  ASSERT_TRUE(ledger.lease_next(1, kStart, kDue).has_value());
  const TileAssignment twice = *ledger.lease_again(0, 2, kStart, kDue);
  ledger.accept(2, kVersion, 0, twice.attempt);
  EXPECT_EQ(ledger.lose_session(1, {"a", "", 0}, true, kStart), 1u);
  EXPECT_EQ(ledger.losses().tiles(), std::vector<TileIndex>{1});
  const auto is_refused = [](TileIndex) { return false; };
  EXPECT_EQ(ledger.next_for(2, is_refused), 2u) << "the tile that was lost is barred";
  EXPECT_EQ(ledger.next_for(2), 1u);
}

TEST(FrameLedger, ATileThatIsDoneIsNoCaseAnyMore) {
  FrameLedger ledger(kVersion, tiles(1));
  ASSERT_TRUE(ledger.lease_next(1, kStart, kDue).has_value());
  ledger.lose_session(1, {"a", "", 0}, true, kStart);
  const TileAssignment lease = *ledger.lease_next(2, kStart, kDue);
  ledger.accept(2, kVersion, 0, lease.attempt);
  EXPECT_TRUE(ledger.losses().is_empty());
}

TEST(FrameLedger, WhatIsHandedBackIsPendingAgainAndNoLoss) {
  FrameLedger ledger(kVersion, tiles(1));
  const TileAssignment lease = *ledger.lease_next(1, kStart, kDue);
  EXPECT_FALSE(ledger.hand_back(2, lease.tile, lease.attempt));
  EXPECT_TRUE(ledger.hand_back(1, lease.tile, lease.attempt));
  EXPECT_FALSE(ledger.hand_back(1, lease.tile, lease.attempt)) << "once";
  ASSERT_TRUE(ledger.lease_next(2, kStart, kDue).has_value());
  EXPECT_TRUE(ledger.losses().is_empty());
  EXPECT_EQ(ledger.lose_session(2, {"b", "", 0}, false, kStart), 0u);
  EXPECT_TRUE(ledger.losses().is_empty()) << "a slave that was expelled makes no tile suspect";
}

}  // namespace
}  // namespace tessera::master
