// SPDX-License-Identifier: Apache-2.0
// Which scene a slave builds next, in virtual time.
#include "slave/build_order.h"

#include <gtest/gtest.h>

#include <vector>

namespace tessera::slave {
namespace {

BuildTask task(SceneVersion version, std::uint64_t generation = 1) {
  return {generation, version, {}};
}

TEST(BuildOrderTest, OldestFirst) {
  BuildOrder order;
  for (const SceneVersion version : {1, 2, 3}) ASSERT_TRUE(order.try_push(task(version)));
  for (const SceneVersion version : {1, 2, 3}) {
    EXPECT_EQ(order.start_next().version, version);
    EXPECT_FALSE(order.is_to_stop());
    EXPECT_TRUE(order.finish(false));
  }
  EXPECT_FALSE(order.has_next());
}

TEST(BuildOrderTest, WhatIsRetiredIsNotBegunAndStops) {
  BuildOrder order;
  for (const SceneVersion version : {1, 2, 3}) ASSERT_TRUE(order.try_push(task(version)));
  EXPECT_EQ(order.start_next().version, 1u);
  order.retire(1, 3);
  EXPECT_TRUE(order.is_to_stop());
  EXPECT_TRUE(order.finish(true)) << "it is answered";
  EXPECT_EQ(order.start_next().version, 3u);
}

TEST(BuildOrderTest, OnlySoManyWait) {
  BuildOrder order;
  for (SceneVersion version = 1; version <= BuildOrder::kWaitingMax; ++version)
    ASSERT_TRUE(order.try_push(task(version)));
  EXPECT_FALSE(order.try_push(task(99)));
  order.retire(1, 2);
  EXPECT_TRUE(order.try_push(task(99)));
}

// An order that is late leaves one scene for a newer one, and no second one before a build has
// reached its end.
TEST(BuildOrderTest, GivesWayOnce) {
  BuildOrder order;
  ASSERT_TRUE(order.try_push(task(1)));
  order.start_next();
  ASSERT_TRUE(order.try_push(task(2)));
  EXPECT_FALSE(order.is_to_stop()) << "it is not late";
  order.retire(1, 2);
  order.finish(true);
  EXPECT_EQ(order.start_next().version, 2u);
  ASSERT_TRUE(order.try_push(task(3)));
  ASSERT_TRUE(order.is_to_stop());
  EXPECT_FALSE(order.finish(true)) << "it waits again, so nobody is told";
  EXPECT_EQ(order.start_next().version, 3u);
  ASSERT_TRUE(order.try_push(task(4)));
  EXPECT_FALSE(order.is_to_stop());
  EXPECT_TRUE(order.finish(false));
  EXPECT_EQ(order.start_next().version, 2u) << "the oldest again";
}

// A build that has reached its end before it saw that it should give way is answered.
TEST(BuildOrderTest, WhoEndsAllTheSameIsAnswered) {
  BuildOrder order;
  ASSERT_TRUE(order.try_push(task(1)));
  order.start_next();
  order.retire(1, 2);
  order.finish(true);
  ASSERT_TRUE(order.try_push(task(2)));
  order.start_next();
  ASSERT_TRUE(order.try_push(task(3)));
  ASSERT_TRUE(order.is_to_stop());
  EXPECT_TRUE(order.finish(false));
  EXPECT_EQ(order.start_next().version, 3u);
}

// Another session's scenes have nothing to do with how late this one is.
TEST(BuildOrderTest, ANewSessionBeginsInTime) {
  BuildOrder order;
  ASSERT_TRUE(order.try_push(task(1, 1)));
  order.start_next();
  order.retire(1, 2);
  order.finish(true);
  order.retire(2, 1);
  ASSERT_TRUE(order.try_push(task(1, 2)));
  order.start_next();
  ASSERT_TRUE(order.try_push(task(2, 2)));
  EXPECT_FALSE(order.is_to_stop());
}

// Every frame brings a scene, two of them are in flight, and others show one frame each `period`:
// at k * period scene k is retired and scene k + 2 comes. Returns: how many scenes were ready
// before they were retired, by a slave that begins when scene 1 has just been asked for.
int ready_in_time(double period, double build) {
  constexpr SceneVersion kFrames = 100;
  BuildOrder order;
  double done = 0;
  bool is_building = false;
  int ready = 0;
  const auto begin = [&](double now) {
    if (is_building || !order.has_next()) return;
    order.start_next();
    is_building = true;
    done = now + build;
  };
  const auto stop_if_due = [&](double now) {
    if (!is_building || !order.is_to_stop()) return;
    order.finish(true);
    is_building = false;
    begin(now);
  };
  EXPECT_TRUE(order.try_push(task(1)) && order.try_push(task(2)));
  begin(0);
  for (SceneVersion frame = 1; frame <= kFrames; ++frame) {
    const double now = static_cast<double>(frame) * period;
    while (is_building && done < now) {
      const double then = done;
      ready += order.finish(false) ? 1 : 0;
      is_building = false;
      begin(then);
    }
    order.retire(1, frame + 1);
    stop_if_due(now);
    // The next scene is on its way for a moment.
    EXPECT_TRUE(order.try_push(task(frame + 2)));
    begin(now + 0.02 * period);
    stop_if_due(now + 0.02 * period);
  }
  return ready;
}

TEST(BuildOrderTest, ASlaveThatFellBehindCatchesUpIfItCan) {
  EXPECT_GE(ready_in_time(1.0, 0.5), 99);
  EXPECT_GE(ready_in_time(1.0, 0.95), 97);
  // A slave that is slower than the others has some scenes ready, where building one after the
  // other gave none at all.
  EXPECT_GE(ready_in_time(1.0, 1.02), 60);
  EXPECT_GE(ready_in_time(1.0, 1.3), 40);
  EXPECT_GE(ready_in_time(1.0, 1.7), 30);
}

}  // namespace
}  // namespace tessera::slave
