// SPDX-License-Identifier: Apache-2.0
// When a connection is pinged and when it is dead.
#include "common/net/liveness.h"

#include <gtest/gtest.h>

namespace tessera::net {
namespace {

using namespace std::chrono_literals;

TEST(Liveness, PingsWhenNothingWasSentAndDiesOfSilence) {
  Liveness liveness(250ms, 4);
  TimePoint now{};
  const TimePoint heard = now;
  for (int i = 0; i < 25; ++i, now += 50ms) {
    EXPECT_EQ(liveness.look(now, now - 249ms, heard), LivenessAction::kNone) << i;
  }
  EXPECT_EQ(liveness.look(now, now - 250ms, heard), LivenessAction::kPing);
  EXPECT_EQ(liveness.look(now + 1ms, now, heard), LivenessAction::kDead);
  EXPECT_EQ(liveness.look(now + 1ms, now, now), LivenessAction::kNone);
}

TEST(Liveness, OurOwnSleepIsNotTheirs) {
  Liveness liveness(250ms, 4);
  const TimePoint t0{};
  EXPECT_EQ(liveness.look(t0, t0, t0), LivenessAction::kNone);
  EXPECT_NE(liveness.look(t0 + 60s, t0, t0), LivenessAction::kDead);
  EXPECT_EQ(liveness.look(t0 + 60s + 50ms, t0, t0), LivenessAction::kDead);
}

// An owner that looks only when it is due finds a silent peer no later than the bound of detection.
TEST(Liveness, WhoLooksWhenDueFindsDeathOnTime) {
  for (auto spoke_last = 0ms; spoke_last < 2000ms; spoke_last += 37ms) {
    Liveness liveness(250ms, 4);
    liveness.set_rtt(20ms);
    TimePoint now{};
    TimePoint sent = now;
    int pings = 0;
    for (;;) {
      const TimePoint heard = TimePoint{} + std::min<Duration>(now - TimePoint{}, spoke_last);
      const LivenessAction action = liveness.look(now, sent, heard);
      if (action == LivenessAction::kDead) break;
      if (action == LivenessAction::kPing) sent = now, ++pings;
      ASSERT_GT(liveness.due(), now);
      now = liveness.due();
    }
    EXPECT_LE(now - TimePoint{}, spoke_last + 5 * 250ms + 20ms + 1ms);
    EXPECT_GE(pings, 4);
  }
}

TEST(Liveness, TheHeartbeatOfAFarPeerIsLongerThanHalfItsRoundTrip) {
  EXPECT_EQ(heartbeat_for(250ms, 4, 0ms), 250ms);
  EXPECT_EQ(heartbeat_for(250ms, 4, 499ms), 250ms);
  for (const auto rtt : {500ms, 1200ms, 5000ms}) {
    EXPECT_GT(4 * heartbeat_for(250ms, 4, rtt), 2 * rtt);
    EXPECT_LE(4 * heartbeat_for(250ms, 4, rtt), 2 * rtt + 8ms);
  }
}

TEST(Liveness, AnIdleLinkIsLookedAtOncePerHeartbeat) {
  Liveness liveness(250ms, 4);
  TimePoint now{};
  int looks = 0;
  for (; now < TimePoint{} + 10s; now = liveness.due(), ++looks) {
    (void)liveness.look(now, now, now);
  }
  EXPECT_EQ(looks, 40);
}

TEST(PingAllowance, WhoPingsOnceAHeartbeatIsNeverOverIt) {
  for (const std::uint32_t heartbeat_ms : {1u, 20u, 250u, 60'000u}) {
    PingAllowance allowance({heartbeat_ms, 4});
    TimePoint now{};
    for (int i = 0; i < 10'000; ++i, now += std::chrono::milliseconds(heartbeat_ms))
      ASSERT_TRUE(allowance.admit(now)) << heartbeat_ms << " ms, number " << i;
  }
}

TEST(PingAllowance, ThoseOfTheLongestSilenceMayComeAtOnceAndAFloodMayNot) {
  const Pulse pulse{250, 59};
  PingAllowance allowance(pulse);
  TimePoint now = TimePoint{} + 1s;
  for (std::uint32_t i = 0; i <= pulse.missed_max; ++i) ASSERT_TRUE(allowance.admit(now)) << i;
  int more = 0;
  while (more < 10'000 && allowance.admit(now)) ++more;
  EXPECT_LT(more, 1'000);
  EXPECT_FALSE(allowance.admit(now + 1ms));
  EXPECT_TRUE(allowance.admit(now + pulse.silence_max()));
}

TEST(Pulse, ApplicationsAreGivenFifteenSecondsAndNeverLessThanSlaves) {
  EXPECT_EQ(application_pulse({}).missed_max, std::uint32_t{kAppHeartbeatsMissedMax});
  for (const std::uint32_t heartbeat_ms : {20u, 250u, 333u, 1000u, 14'999u, 60'000u}) {
    for (const std::uint32_t missed_max : {1u, 4u, 100u}) {
      const Pulse slaves{heartbeat_ms, missed_max};
      const Pulse application = application_pulse(slaves);
      EXPECT_GE(application.silence_max(), 15s);
      EXPECT_GE(application.silence_max(), slaves.silence_max());
      EXPECT_GE(application.heartbeat_ms, heartbeat_ms);
      EXPECT_LE(application.missed_max, Pulse::kMissedMost);
    }
  }
}

}  // namespace
}  // namespace tessera::net
