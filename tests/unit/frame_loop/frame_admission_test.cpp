// SPDX-License-Identifier: Apache-2.0
// Frames in front of the memory for their pixels: who goes on, who waits, who is refused.
#include "master/frame_loop/frame_admission.h"

#include <gtest/gtest.h>

#include "master/frame_loop/loop_gap.h"

namespace tessera::master {
namespace {

using namespace std::chrono_literals;
using Verdict = FrameAdmission::Verdict;

const TimePoint kStart{1000s};
constexpr std::uint64_t kMib = std::uint64_t{1} << 20;
constexpr std::uint64_t kReserve = FrameAdmission::kReserveBytes;

class FrameAdmissionTest : public testing::Test {
 protected:
  // Returns: the verdict on the first frame; nothing while it waits.
  std::optional<Verdict> next(FrameHoldings holdings = {}, TimePoint now = kStart) {
    const auto decision = admission_.next(holdings, now);
    if (!decision) return std::nullopt;
    last_ = *decision;
    return decision->verdict;
  }

  std::optional<std::uint64_t> room_ = 600 * kMib;
  FrameAdmission admission_{[this] { return room_; }};
  FrameAdmission::Decision last_;
};

TEST_F(FrameAdmissionTest, WithoutAKnownLimitEveryFrameGoesOn) {
  room_ = std::nullopt;
  admission_.add(1, std::uint64_t{1} << 40, kStart);
  EXPECT_EQ(next(), Verdict::kTaken);
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_TRUE(FrameAdmission(nullptr).free_bytes({}) == std::nullopt);
}

TEST_F(FrameAdmissionTest, AFrameThatCannotFitIsRefusedAndTheNextGoesOn) {
  admission_.add(1, 3072 * kMib, kStart);
  admission_.add(2, 4 * kMib, kStart);
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_EQ(next({}, kStart + 999ms), std::nullopt);
  EXPECT_EQ(next({}, kStart + 1s), Verdict::kRefused);
  EXPECT_EQ(last_.frame, 1u);
  EXPECT_EQ(last_.needed_bytes, 3072 * kMib);
  EXPECT_EQ(last_.free_bytes, 600 * kMib - kReserve);
  EXPECT_EQ(next(), Verdict::kTaken);
  EXPECT_EQ(last_.frame, 2u);
}

TEST_F(FrameAdmissionTest, WhatIsPromisedIsNotFreeThoughNothingIsWrittenYet) {
  admission_.add(1, 300 * kMib, kStart);
  EXPECT_EQ(next(), Verdict::kTaken);
  admission_.add(2, 300 * kMib, kStart);
  EXPECT_EQ(next({300 * kMib, 0}), std::nullopt) << "the room is what it was, and spoken for";
  room_ = 400 * kMib;  // 200 MiB of the first frame are written
  EXPECT_EQ(next({100 * kMib, 200 * kMib}), std::nullopt);
  room_ = 300 * kMib;
  EXPECT_EQ(next({0, 300 * kMib}), std::nullopt) << "finished, and not yet given away";
  room_ = 600 * kMib;
  EXPECT_EQ(next(), Verdict::kTaken);
}

TEST_F(FrameAdmissionTest, ExactlyWhatIsFreeFits) {
  admission_.add(1, room_.value() - kReserve, kStart);
  admission_.add(2, room_.value() - kReserve + 1, kStart);
  EXPECT_EQ(next(), Verdict::kTaken);
  EXPECT_EQ(next(), std::nullopt);
  EXPECT_EQ(next({}, kStart + 1s), Verdict::kRefused);
}

// The picture before is dropped and its memory not back yet: for a moment it is nobody's.
TEST_F(FrameAdmissionTest, MemoryOnItsWayBackIsWaitedFor) {
  room_ = 100 * kMib;
  admission_.add(1, 300 * kMib, kStart);
  EXPECT_EQ(next({0, 400 * kMib}), std::nullopt);
  EXPECT_EQ(next({}, kStart + 20s), std::nullopt);
  EXPECT_EQ(next({0, 400 * kMib}, kStart + 21s), std::nullopt) << "there is hope again";
  EXPECT_EQ(next({}, kStart + 22s), std::nullopt);
  room_ = 600 * kMib;
  EXPECT_EQ(next({}, kStart + 22500ms), Verdict::kTaken);
}

TEST_F(FrameAdmissionTest, AFrameThatOthersMayMakeRoomForWaitsInOrderAndNotForEver) {
  room_ = 100 * kMib;
  admission_.add(1, 300 * kMib, kStart);
  admission_.add(2, 1, kStart);
  const FrameHoldings held{0, 400 * kMib};
  EXPECT_EQ(next(held, kStart + 59s), std::nullopt) << "the second does not overtake";
  EXPECT_EQ(next(held, kStart + 60s), Verdict::kRefused);
  EXPECT_EQ(last_.frame, 1u);
  admission_.add(3, 300 * kMib, kStart + 61s);
  EXPECT_EQ(next(held, kStart + 61s), Verdict::kTaken);
  EXPECT_EQ(next(held, kStart + 100s), std::nullopt) << "its time began with its turn";
}

TEST_F(FrameAdmissionTest, ACancelledFrameLeavesWhenItsTurnComes) {
  room_ = 0;
  admission_.add(1, 300 * kMib, kStart);
  admission_.add(2, 300 * kMib, kStart);
  EXPECT_FALSE(admission_.cancel(3));
  EXPECT_TRUE(admission_.cancel(2));
  EXPECT_EQ(next({0, 900 * kMib}), std::nullopt);
  EXPECT_TRUE(admission_.cancel(1));
  EXPECT_EQ(next({0, 900 * kMib}), Verdict::kCancelled);
  EXPECT_EQ(next({0, 900 * kMib}), Verdict::kCancelled);
  EXPECT_EQ(last_.frame, 2u);
  EXPECT_TRUE(admission_.is_empty());
}

TEST_F(FrameAdmissionTest, LittleRoomIsNoneAndNeverLess) {
  room_ = kReserve - 1;
  EXPECT_EQ(admission_.free_bytes({}), 0u);
  EXPECT_EQ(admission_.free_bytes({5 * kMib, 0}), 0u);
}

TEST(LoopGap, IsWhatATaskComesTooLateBy) {
  LoopGap gap(10ms);
  EXPECT_EQ(gap.tick(kStart), Duration::zero());
  EXPECT_EQ(gap.tick(kStart + 10ms), Duration::zero());
  EXPECT_EQ(gap.tick(kStart + 90ms), 70ms);
  EXPECT_EQ(gap.tick(kStart + 91ms), Duration::zero()) << "a timer that catches up";
}

}  // namespace
}  // namespace tessera::master
