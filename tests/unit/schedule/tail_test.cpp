// SPDX-License-Identifier: Apache-2.0
// The scheduler in virtual time: no thread is idle at any distance, slow slaves hold up nobody,
// tails are short, and little work is done twice.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/support/schedule_world.h"

namespace tessera::master {
namespace {

constexpr int kFrames = 40;
constexpr TileIndex kTiles = 96;

std::vector<WorldSlave> slaves(std::size_t count, WorldSlave each = {}) {
  return std::vector<WorldSlave>(count, each);
}

TEST(Tail, NoThreadIsIdleAtAnyRoundTrip) {
  for (const double round_trip : {0.0001, 0.001, 0.010, 0.050}) {
    for (const double spread : {0.0, 0.8}) {
      const WorldResult r =
          ScheduleWorld({}, slaves(4, {2, 0.010, round_trip}), spread).run(kFrames, kTiles);
      EXPECT_GE(r.utilisation, 0.95) << round_trip << " s, spread " << spread;
    }
  }
}

TEST(Tail, WithoutPrefetchTheNetworkIsWaitedFor) {
  SchedulerOptions options;
  options.prefetch_per_thread = 0;
  const WorldResult r = ScheduleWorld(options, slaves(4, {2, 0.010, 0.050})).run(kFrames, kTiles);
  EXPECT_LT(r.utilisation, 0.25) << "else the test above shows nothing";
}

TEST(Tail, ASlaveTenTimesSlowerHoldsUpNobody) {
  std::vector<WorldSlave> with = slaves(4);
  with.push_back({1, 0.100, 0.0002});
  for (const int in_flight : {1, 2}) {
    SchedulerOptions options;
    options.frames_in_flight = in_flight;
    const WorldResult without = ScheduleWorld(options, slaves(4)).run(kFrames, kTiles);
    const WorldResult r = ScheduleWorld(options, with).run(kFrames, kTiles);
    EXPECT_LE(r.seconds, 1.02 * without.seconds) << in_flight;
    EXPECT_LT(r.tiles_by_slave[4], r.tiles_by_slave[0] / 5);
    EXPECT_GT(r.tiles_by_slave[4], 0u);
  }
}

TEST(Tail, AFarSlaveHoldsUpNobody) {
  std::vector<WorldSlave> with = slaves(4);
  with.push_back({1, 0.010, 0.500});
  SchedulerOptions options;
  options.frames_in_flight = 1;
  const WorldResult without = ScheduleWorld(options, slaves(4)).run(kFrames, kTiles);
  const WorldResult r = ScheduleWorld(options, with).run(kFrames, kTiles);
  EXPECT_LE(r.seconds, 1.1 * without.seconds);
}

TEST(Tail, EqualSlavesDoHardlyAnythingTwice) {
  for (const double spread : {0.0, 0.5, 1.0}) {
    const WorldResult r = ScheduleWorld({}, slaves(8, {2, 0.010, 0.001}), spread).run(100, kTiles);
    EXPECT_LE(r.duplicated_share, 0.01) << spread;
  }
}

TEST(Tail, StragglersCostAtMostATwentiethMore) {
  std::vector<WorldSlave> with = slaves(6, {2, 0.010, 0.001});
  with.push_back({2, 0.080, 0.001});
  with.push_back({1, 0.200, 0.001});
  for (const double spread : {0.0, 0.5, 1.0}) {
    const WorldResult r = ScheduleWorld({}, with, spread).run(100, kTiles);
    EXPECT_LE(r.duplicated_share, 0.05) << spread;
  }
}

TEST(Tail, TilesOfASlaveThatHangsAreDoneByOthersLongBeforeItsDeathIsNoticed) {
  std::vector<WorldSlave> with = slaves(4);
  with[3].hangs_at = 2.0;
  const WorldResult r = ScheduleWorld({}, with).run(kFrames, kTiles);
  EXPECT_LT(r.seconds, 1e9) << "frames went on coming";
  const double usual = kTiles * 0.010 / 4;
  EXPECT_LE(r.worst_frame, 2 * usual + 0.2);
}

// A of the fault matrix is two tile times here. A copy waits for the tile in work before it.
TEST(Tail, ASlaveThatHangsCostsTheFrameInWorkTwoTilesAndNoOtherFrameMore) {
  constexpr double kTile = 0.040, kLook = 0.010;
  for (int step = 0; step < 40; ++step) {
    std::vector<WorldSlave> with = slaves(3, {1, kTile, 0.0002});
    with[2].hangs_at = 4.0 + 0.021 * step;
    const WorldResult r = ScheduleWorld({}, with).run(kFrames, 48);
    const double without = 48 * kTile / 2;
    EXPECT_LE(r.worst_frame, without + 2 * kTile + kTile + 2 * kLook) << with[2].hangs_at;
  }
}

// What an audit costs: as many tiles more as are compared, and of time hardly more than that.
TEST(Tail, AuditsCostTheTilesThatAreComparedAndNoDuplicates) {
  SchedulerOptions audits;
  audits.audit.share = 0.01;
  for (const double spread : {0.0, 0.8}) {
    const auto cluster = slaves(8, {2, 0.010, 0.001});
    const WorldResult without = ScheduleWorld({}, cluster, spread).run(200, kTiles);
    const WorldResult r = ScheduleWorld(audits, cluster, spread).run(200, kTiles);
    std::printf("spread %.1f: %.2f %% compared, %.2f %% leased again, %.2f %% more time\n", spread,
                100 * r.compared_share, 100 * r.duplicated_share,
                100 * (r.seconds / without.seconds - 1));
    EXPECT_NEAR(r.compared_share, 0.01, 0.002) << spread;
    EXPECT_LE(r.duplicated_share, 0.01) << spread;
    EXPECT_LE(r.seconds, 1.02 * without.seconds) << spread;
    EXPECT_EQ(without.compared_share, 0);
  }
}

// As the one above, in frames shorter than a slave must be silent to have stalled. The bound is a
// frame of the other two slaves, which audits make longer.
TEST(Tail, AnAuditedTileOfASlaveThatHangsWaitsNoLongerThanAnother) {
  constexpr TileIndex kFew = 12;
  constexpr double kTile = 0.040, kLook = 0.010;
  SchedulerOptions audits;
  audits.audit.share = 0.3;
  const double without =
      ScheduleWorld(audits, slaves(2, {1, kTile, 0.0002})).run(kFrames, kFew).worst_frame;
  for (int step = 0; step < 40; ++step) {
    std::vector<WorldSlave> with = slaves(3, {1, kTile, 0.0002});
    with[2].hangs_at = 4.0 + 0.021 * step;
    const WorldResult r = ScheduleWorld(audits, with).run(kFrames, kFew);
    EXPECT_LE(r.worst_frame, without + 2 * kTile + kTile + 2 * kLook) << with[2].hangs_at;
  }
}

TEST(Tail, AStaticScheduleWaitsForTheSlowest) {
  std::vector<WorldSlave> with = slaves(4);
  with.push_back({1, 0.030, 0.0002});
  SchedulerOptions fixed;
  fixed.is_static = true;
  const WorldResult dynamic = ScheduleWorld({}, with).run(kFrames, kTiles);
  const WorldResult r = ScheduleWorld(fixed, with).run(kFrames, kTiles);
  EXPECT_GT(r.seconds, 1.8 * dynamic.seconds);
}

}  // namespace
}  // namespace tessera::master
