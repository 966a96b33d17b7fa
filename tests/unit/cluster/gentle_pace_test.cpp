// SPDX-License-Identifier: Apache-2.0
// A gentle transfer sends one window at a time and then rests for as long as that took.
#include "master/cluster/gentle_pace.h"

#include <gtest/gtest.h>

namespace tessera::master {
namespace {

using std::chrono::milliseconds;

TEST(GentlePace, HalfOfTheLinkAndNoMoreThanAWindowOnTheWay) {
  GentlePace pace;
  TimePoint now{};
  net::LinkCounters idle, busy;
  busy.on_the_way_bytes = 1000;
  ASSERT_TRUE(pace.may_send(now, idle));
  pace.sent(now);
  EXPECT_FALSE(pace.may_send(now + milliseconds(3), busy));
  EXPECT_FALSE(pace.may_send(now + milliseconds(10), idle)) << "arrived after 10 ms";
  EXPECT_FALSE(pace.may_send(now + milliseconds(19), idle));
  EXPECT_TRUE(pace.may_send(now + milliseconds(20), idle));
}

TEST(GentlePace, AWindowThatNeverArrivesDoesNotHoldItForEver) {
  GentlePace pace;
  TimePoint now{};
  net::LinkCounters busy;
  busy.queue_bytes = 1;
  pace.sent(now);
  now += GentlePace::kWindowTimeMax;
  EXPECT_FALSE(pace.may_send(now, busy)) << "the rest first";
  EXPECT_TRUE(pace.may_send(now + GentlePace::kWindowTimeMax, busy));
}

}  // namespace
}  // namespace tessera::master
