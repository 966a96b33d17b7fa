// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/scheduler.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "common/base/limits.h"

namespace tessera::master {
namespace {

using namespace std::chrono_literals;
const TimePoint kStart{};
constexpr double kTileSeconds = 0.010;  // every tile takes this long

std::vector<Action> of(const Actions& actions, ActionKind kind, SessionId session = 0) {
  std::vector<Action> found;
  for (const Action& a : actions) {
    if (a.kind == kind && (session == 0 || a.session == session)) found.push_back(a);
  }
  return found;
}

const SchedulerOptions kFixedPrefetch{3, 2, false, {}};

std::vector<TileIndex> tiles(TileIndex count) {
  std::vector<TileIndex> order(count);
  std::iota(order.begin(), order.end(), TileIndex{0});
  return order;
}

// A started scheduler with slaves 1..count, one thread each, that have built version 1.
Scheduler cluster_of(int count, SchedulerOptions options = {}) {
  Scheduler scheduler(options);
  for (int i = 1; i <= count; ++i)
    scheduler.slave_joined(static_cast<SessionId>(i), {"s" + std::to_string(i), "", 0}, 1, kStart);
  EXPECT_TRUE(scheduler.start(kStart).empty());
  for (int i = 1; i <= count; ++i) {
    EXPECT_TRUE(scheduler.scene_built(static_cast<SessionId>(i), 1, kStart).empty());
  }
  return scheduler;
}

Actions answer(Scheduler& scheduler, const Action& lease, TimePoint now,
               ResultVerdict expected = ResultVerdict::kAccepted, SceneVersion version = 1) {
  Actions actions;
  const TileReport report{
      lease.frame, version, lease.tile.tile, lease.tile.attempt, kTileSeconds, kTileSeconds, 0, 0};
  EXPECT_EQ(scheduler.result(lease.session, report, now, actions), expected);
  return actions;
}

TEST(Scheduler, NothingIsLeasedBeforeTheSessionHasStarted) {
  Scheduler scheduler({});
  scheduler.slave_joined(1, {"s1", "", 0}, 2, kStart);
  EXPECT_TRUE(scheduler.scene_built(1, 1, kStart).empty());
  EXPECT_TRUE(scheduler.submit_frame(0, 1, tiles(10), kStart).empty());
  EXPECT_FALSE(of(scheduler.start(kStart), ActionKind::kLease).empty());
}

TEST(Scheduler, ASlaveGetsItsThreadsPlusThePrefetch) {
  Scheduler scheduler = cluster_of(1);
  const Actions actions = scheduler.submit_frame(0, 1, tiles(100), kStart);
  EXPECT_EQ(actions.front().kind, ActionKind::kBeginFrame) << "before its first tile";
  EXPECT_EQ(of(actions, ActionKind::kLease).size(), 4u) << "1 thread x (3 + 1)";
  EXPECT_EQ(scheduler.tiles_in_flight(1), 4u);
}

TEST(Scheduler, OneResultBringsOneNewTile) {
  Scheduler scheduler = cluster_of(1, kFixedPrefetch);
  const Actions actions = scheduler.submit_frame(0, 1, tiles(100), kStart);
  const Actions next = answer(scheduler, of(actions, ActionKind::kLease)[0], kStart + 5ms);
  EXPECT_EQ(of(next, ActionKind::kLease).size(), 1u);
  EXPECT_EQ(scheduler.tiles_in_flight(1), 4u);
}

TEST(Scheduler, TilesGoOnlyToSlavesThatHaveBuiltTheVersion) {
  Scheduler scheduler = cluster_of(2);
  EXPECT_TRUE(scheduler.submit_frame(0, 2, tiles(10), kStart).empty());
  const Actions actions = scheduler.scene_built(2, 2, kStart);
  EXPECT_TRUE(of(actions, ActionKind::kLease, 1).empty());
  EXPECT_FALSE(of(actions, ActionKind::kLease, 2).empty());
}

TEST(Scheduler, TwoFramesAreInFlightAndTheThirdWaits) {
  Scheduler scheduler = cluster_of(1, kFixedPrefetch);
  const Actions first = scheduler.submit_frame(0, 1, tiles(2), kStart);
  const Actions second = scheduler.submit_frame(1, 1, tiles(2), kStart);
  EXPECT_EQ(of(second, ActionKind::kLease).size(), 2u) << "beside the tail of frame 0";
  EXPECT_TRUE(scheduler.submit_frame(2, 1, tiles(2), kStart).empty());
  answer(scheduler, of(first, ActionKind::kLease)[0], kStart);
  const Actions done = answer(scheduler, of(first, ActionKind::kLease)[1], kStart);
  EXPECT_EQ(of(done, ActionKind::kFrameComplete).size(), 1u);
  EXPECT_EQ(of(done, ActionKind::kEndFrame).size(), 1u);
  const std::vector<Action> leases = of(done, ActionKind::kLease);
  ASSERT_FALSE(leases.empty());
  EXPECT_EQ(leases[0].frame, 2u);
}

TEST(Scheduler, WithOneFrameInFlightTheSecondWaits) {
  Scheduler scheduler = cluster_of(1, {3, 1, false, 0});
  EXPECT_FALSE(scheduler.submit_frame(0, 1, tiles(2), kStart).empty());
  EXPECT_TRUE(scheduler.submit_frame(1, 1, tiles(2), kStart).empty());
}

TEST(Scheduler, FramesComeOutInOrderAlsoWhenTheLaterIsReadyFirst) {
  Scheduler scheduler = cluster_of(1);
  const Actions first = scheduler.submit_frame(0, 1, tiles(1), kStart);
  const Actions second = scheduler.submit_frame(1, 1, tiles(1), kStart);
  EXPECT_TRUE(
      of(answer(scheduler, of(second, ActionKind::kLease)[0], kStart), ActionKind::kFrameComplete)
          .empty());
  const std::vector<Action> done =
      of(answer(scheduler, of(first, ActionKind::kLease)[0], kStart), ActionKind::kFrameComplete);
  ASSERT_EQ(done.size(), 2u);
  EXPECT_EQ(done[0].frame, 0u);
  EXPECT_EQ(done[1].frame, 1u);
}

TEST(Scheduler, TheTilesOfALostSlaveGoToTheOthersAtOnce) {
  Scheduler scheduler = cluster_of(2, kFixedPrefetch);
  const Actions actions = scheduler.submit_frame(0, 1, tiles(5), kStart);
  const std::vector<Action> of_two = of(actions, ActionKind::kLease, 2);
  ASSERT_EQ(of_two.size() + of(actions, ActionKind::kLease, 1).size(), 5u);
  Actions next;
  for (const Action& lease : of(actions, ActionKind::kLease, 1)) {
    for (const Action& a : answer(scheduler, lease, kStart)) next.push_back(a);
  }
  for (const Action& a : scheduler.slave_lost(2, kStart)) next.push_back(a);
  std::set<TileIndex> again;
  for (const Action& a : of(next, ActionKind::kLease, 1)) again.insert(a.tile.tile);
  for (const Action& a : of_two) EXPECT_TRUE(again.contains(a.tile.tile)) << a.tile.tile;
  Actions ignored;
  EXPECT_EQ(scheduler.result(2, {0, 1, of_two[0].tile.tile, of_two[0].tile.attempt, 0, 0, 0, 0},
                             kStart, ignored),
            ResultVerdict::kNotLeased)
      << "nothing that the lost one says counts any more";
}

TEST(Scheduler, ATileHandedBackByTheOnlySlaveIsTriedAgain) {
  Scheduler scheduler = cluster_of(1);
  const Action lease = of(scheduler.submit_frame(0, 1, tiles(1), kStart), ActionKind::kLease)[0];
  EXPECT_TRUE(scheduler.tile_returned(1, 0, lease.tile.tile, lease.tile.attempt, kStart).empty());
  EXPECT_TRUE(of(scheduler.tick(kStart + 50ms), ActionKind::kLease).empty()) << "it may be leaving";
  EXPECT_EQ(of(scheduler.tick(kStart + 6s), ActionKind::kLease).size(), 1u);
}

TEST(Scheduler, SlavesThatLeaveTogetherDoNotPassTilesAround) {
  Scheduler scheduler = cluster_of(2);
  const Actions actions = scheduler.submit_frame(0, 1, tiles(8), kStart);
  std::size_t leases_again = 0;
  for (const Action& lease : of(actions, ActionKind::kLease)) {
    leases_again +=
        of(scheduler.tile_returned(lease.session, 0, lease.tile.tile, lease.tile.attempt, kStart),
           ActionKind::kLease)
            .size();
  }
  EXPECT_LE(leases_again, 4u) << "to the second, before it says that it leaves too";
  scheduler.slave_joined(9, {"s9", "", 0}, 1, kStart);
  EXPECT_FALSE(of(scheduler.scene_built(9, 1, kStart + 1s), ActionKind::kLease).empty());
}

TEST(Scheduler, AVersionStaysUsableHoweverManyAreBuiltAfterIt) {
  Scheduler scheduler = cluster_of(1, kFixedPrefetch);
  const Actions first = scheduler.submit_frame(0, 1, tiles(100), kStart);
  for (SceneVersion version = 2; version < 50; ++version) scheduler.scene_built(1, version, kStart);
  EXPECT_EQ(
      of(answer(scheduler, of(first, ActionKind::kLease)[0], kStart), ActionKind::kLease).size(),
      1u);
  scheduler.retire_scenes(40);
  EXPECT_EQ(scheduler.oldest_version_needed(49), 1u);
}

TEST(Scheduler, ARefusedFrameFailsInItsTurn) {
  Scheduler scheduler = cluster_of(1);
  const Actions first = scheduler.submit_frame(0, 1, tiles(1), kStart);
  EXPECT_TRUE(scheduler.refuse_frame(1, "no memory").empty());
  const Actions done = answer(scheduler, of(first, ActionKind::kLease)[0], kStart);
  EXPECT_EQ(of(done, ActionKind::kFrameComplete).size(), 1u);
  ASSERT_EQ(of(done, ActionKind::kFrameFailed).size(), 1u);
  EXPECT_EQ(of(done, ActionKind::kFrameFailed)[0].reason, "no memory");
}

TEST(Scheduler, ATileThatNobodyCanRenderFailsItsFrame) {
  Scheduler scheduler = cluster_of(1);
  Actions actions = scheduler.submit_frame(0, 1, tiles(1), kStart);
  std::vector<Action> failed;
  TimePoint now = kStart;
  for (int lease = 0; lease < kTileLeasesMax + 2; ++lease) {
    ASSERT_TRUE(failed.empty()) << lease;
    const std::vector<Action> leases = of(actions, ActionKind::kLease);
    ASSERT_EQ(leases.size(), 1u);
    const TileAssignment tile = leases[0].tile;
    failed =
        of(scheduler.tile_returned(1, 0, tile.tile, tile.attempt, now), ActionKind::kFrameFailed);
    actions = scheduler.tick(now += 6s);
  }
  ASSERT_EQ(failed.size(), 1u);
  EXPECT_NE(failed[0].reason.find("unrendered"), std::string::npos);
}

TEST(Scheduler, WithoutAnySlaveTheFrameIsKept) {
  Scheduler scheduler = cluster_of(1);
  scheduler.submit_frame(0, 1, tiles(3), kStart);
  EXPECT_TRUE(of(scheduler.slave_lost(1, kStart), ActionKind::kFrameFailed).empty());
  scheduler.slave_joined(9, {"s9", "", 0}, 1, kStart);
  EXPECT_EQ(of(scheduler.scene_built(9, 1, kStart), ActionKind::kLease).size(), 3u);
}

TEST(Scheduler, ASceneThatNoSlaveCanHoldFailsItsFrameWithTheReason) {
  Scheduler scheduler = cluster_of(2);
  scheduler.submit_frame(0, 2, tiles(3), kStart);
  EXPECT_TRUE(
      of(scheduler.scene_failed(1, 2, "no memory", kStart), ActionKind::kFrameFailed).empty());
  const std::vector<Action> failed =
      of(scheduler.scene_failed(2, 2, "no memory", kStart), ActionKind::kFrameFailed);
  ASSERT_EQ(failed.size(), 1u);
  EXPECT_NE(failed[0].reason.find("no memory"), std::string::npos);
}

TEST(Scheduler, ASlaveThatCouldHoldTheSceneMayComeBack) {
  Scheduler scheduler = cluster_of(2);
  scheduler.submit_frame(0, 2, tiles(3), kStart);
  scheduler.scene_failed(1, 2, "no memory", kStart);
  EXPECT_TRUE(of(scheduler.slave_lost(2, kStart), ActionKind::kFrameFailed).empty())
      << "its link was silent for a moment";
  const TimePoint later = kStart + DepartedSlaves::kReturn - 1ms;
  EXPECT_TRUE(of(scheduler.submit_frame(1, 2, tiles(3), later), ActionKind::kFrameFailed).empty());
  EXPECT_TRUE(scheduler.tick(later).empty());
  scheduler.slave_joined(3, {"s2", "", 0}, 1, kStart);
  EXPECT_EQ(of(scheduler.scene_built(3, 2, later), ActionKind::kLease).size(), 4u);
}

TEST(Scheduler, AFrameThatOnlyADepartedSlaveCouldHoldFailsAndNamesIt) {
  Scheduler scheduler = cluster_of(2);
  scheduler.submit_frame(0, 2, tiles(3), kStart);
  scheduler.scene_failed(1, 2, "no memory", kStart);
  scheduler.slave_lost(2, kStart);
  const std::vector<Action> failed =
      of(scheduler.tick(kStart + DepartedSlaves::kReturn), ActionKind::kFrameFailed);
  ASSERT_EQ(failed.size(), 1u);
  EXPECT_NE(failed[0].reason.find("'s2'"), std::string::npos) << failed[0].reason;
}

TEST(Scheduler, ASlaveThatLeftLongAgoIsNoReason) {
  Scheduler scheduler = cluster_of(2);
  scheduler.slave_lost(2, kStart);
  const TimePoint later = kStart + 2 * DepartedSlaves::kReturn;
  scheduler.submit_frame(0, 2, tiles(3), later);
  const std::vector<Action> failed =
      of(scheduler.scene_failed(1, 2, "no memory", later), ActionKind::kFrameFailed);
  ASSERT_EQ(failed.size(), 1u);
  EXPECT_EQ(failed[0].reason.find("'s2'"), std::string::npos) << failed[0].reason;
}

TEST(Scheduler, ASlaveThatHadRefusedTheSceneIsNotWaitedFor) {
  Scheduler scheduler = cluster_of(2);
  scheduler.submit_frame(0, 2, tiles(3), kStart);
  scheduler.scene_failed(2, 2, "no memory", kStart);
  scheduler.slave_lost(2, kStart);
  EXPECT_EQ(of(scheduler.scene_failed(1, 2, "no memory", kStart), ActionKind::kFrameFailed).size(),
            1u);
}

TEST(Scheduler, ACancelledFrameEndsOnceAndItsLateResultsAreDropped) {
  Scheduler scheduler = cluster_of(1);
  const Actions actions = scheduler.submit_frame(0, 1, tiles(3), kStart);
  const std::vector<Action> failed =
      of(scheduler.cancel_frame(0, kStart), ActionKind::kFrameFailed);
  ASSERT_EQ(failed.size(), 1u);
  EXPECT_TRUE(failed[0].is_cancelled);
  EXPECT_TRUE(scheduler.cancel_frame(0, kStart).empty());
  answer(scheduler, of(actions, ActionKind::kLease)[0], kStart, ResultVerdict::kFrameEnded);
}

// Runs a frame of one audited tile, for which each slave answers with its pixels of `pixels_of`.
// Returns: all actions.
Actions audit(int slave_count, const std::vector<std::uint64_t>& pixels_of) {
  Scheduler scheduler = cluster_of(slave_count, {3, 2, false, {1.0}});
  Actions all, next = scheduler.submit_frame(0, 1, tiles(1), kStart);
  while (!of(next, ActionKind::kLease).empty()) {
    const std::vector<Action> leases = of(next, ActionKind::kLease);
    next.clear();
    for (const Action& lease : leases) {
      const std::uint64_t pixels = pixels_of[static_cast<std::size_t>(lease.session - 1)];
      scheduler.result(
          lease.session,
          {0, 1, lease.tile.tile, lease.tile.attempt, kTileSeconds, kTileSeconds, 0, pixels},
          kStart, next);
    }
    if (next.empty()) next = scheduler.tick(kStart + 10ms);  // the third slave's lease
    all.insert(all.end(), next.begin(), next.end());
  }
  return all;
}

TEST(Scheduler, AnAuditExpelsTheSlaveThatTwoOthersContradict) {
  for (std::size_t liar = 0; liar < 3; ++liar) {
    std::vector<std::uint64_t> pixels{5, 5, 5};
    pixels[liar] = 6;
    const Actions actions = audit(3, pixels);
    EXPECT_EQ(of(actions, ActionKind::kFrameComplete).size(), 1u);
    const std::vector<Action> expelled = of(actions, ActionKind::kExpel);
    if (!expelled.empty()) {
      EXPECT_EQ(expelled[0].session, liar + 1);
    } else {
      EXPECT_EQ(liar, 2u) << "two honest ones were asked first";
    }
  }
}

TEST(Scheduler, AnAuditOfTwoThatDifferFailsTheFrameNamingBoth) {
  const std::vector<Action> failed = of(audit(2, {5, 6}), ActionKind::kFrameFailed);
  ASSERT_EQ(failed.size(), 1u);
  EXPECT_NE(failed[0].reason.find("'s1' and 's2'"), std::string::npos) << failed[0].reason;
}

TEST(Scheduler, WhoHasTheSceneFirstIsAuditedByThoseWhoHaveItLater) {
  for (const bool can_hold : {true, false}) {
    Scheduler scheduler = cluster_of(1, {3, 2, false, {1.0}});
    scheduler.slave_joined(2, {"s2", "", 0}, 1, kStart);
    const Actions actions = scheduler.submit_frame(0, 1, tiles(1), kStart);
    const Action lease = of(actions, ActionKind::kLease, 1)[0];
    Actions next;
    scheduler.result(1,
                     {0, 1, lease.tile.tile, lease.tile.attempt, kTileSeconds, kTileSeconds, 0, 5},
                     kStart, next);
    EXPECT_TRUE(of(next, ActionKind::kFrameComplete).empty());
    if (!can_hold) {
      next = scheduler.scene_failed(2, 1, "too large", kStart);
      EXPECT_EQ(of(next, ActionKind::kFrameComplete).size(), 1u) << "nobody is left";
      continue;
    }
    next = scheduler.scene_built(2, 1, kStart);
    const Action second = of(next, ActionKind::kLease, 2)[0];
    next.clear();
    scheduler.result(
        2, {0, 1, second.tile.tile, second.tile.attempt, kTileSeconds, kTileSeconds, 0, 6}, kStart,
        next);
    EXPECT_EQ(of(next, ActionKind::kFrameFailed).size(), 1u);
  }
}

TEST(Scheduler, ResultsThatNobodyAskedForAreViolations) {
  Scheduler scheduler = cluster_of(2);
  const Actions actions = scheduler.submit_frame(0, 1, tiles(100), kStart);
  const Action lease = of(actions, ActionKind::kLease, 1)[0];
  answer(scheduler, lease, kStart, ResultVerdict::kWrongVersion, 2);
  Action stolen = lease;
  stolen.session = 2;
  answer(scheduler, stolen, kStart, ResultVerdict::kNotLeased);
  Action future = lease;
  future.frame = 77;
  answer(scheduler, future, kStart, ResultVerdict::kUnknownFrame);
  Action outside = lease;
  outside.tile.tile = 100;
  answer(scheduler, outside, kStart, ResultVerdict::kNotLeased);
  answer(scheduler, lease, kStart);  // the lease has survived all that
}

}  // namespace
}  // namespace tessera::master
