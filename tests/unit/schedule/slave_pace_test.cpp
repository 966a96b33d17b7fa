// SPDX-License-Identifier: Apache-2.0
#include "master/schedule/slave_pace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/base/limits.h"

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

// A slave whose tiles took `tile` seconds each, over a link of this round trip.
SlavePace pace_of(std::uint32_t threads, double tile, double round_trip,
                  int prefetch = SlavePace::kPrefetchAuto) {
  SlavePace pace(threads, prefetch);
  TimePoint now{};
  for (int i = 0; i < 100; ++i) {
    pace.tile_done(now, 3 * tile + round_trip, 3 * tile, tile);
    now += from_seconds(tile / threads);
  }
  return pace;
}

TEST(SlavePace, BeginsWithThreeTilesWaitingPerThread) {
  EXPECT_EQ(SlavePace(2, SlavePace::kPrefetchAuto).depth(), 8u);
}

TEST(SlavePace, TheDepthCoversTheRoundTrip) {
  EXPECT_EQ(pace_of(1, 0.010, 0.0002).depth(), 3u) << "one in work, one waiting, one being sent";
  EXPECT_EQ(pace_of(1, 0.010, 0.0499).depth(), 7u);
  EXPECT_EQ(pace_of(8, 0.010, 0.0299).depth(), 8u * 4 + 1);
}

TEST(SlavePace, TheDepthIsBoundedHoweverFarTheSlave) {
  EXPECT_EQ(pace_of(2, 0.001, 5).depth(), 2u * kTilesPerWorkerMax);
}

TEST(SlavePace, AFixedPrefetchStaysFixed) {
  EXPECT_EQ(pace_of(4, 0.010, 0.5, 0).depth(), 4u);
  EXPECT_EQ(pace_of(4, 0.010, 0.5, 2).depth(), 12u);
}

TEST(SlavePace, StarvationDeepensTheQueueAndQuietGivesItBack) {
  SlavePace pace = pace_of(1, 0.010, 0.0002);
  for (int i = 0; i < 100; ++i) pace.starved();
  EXPECT_EQ(pace.depth(), 6u) << "twice the computed depth at most";
  TimePoint now{};
  for (int i = 0; i < 200000; ++i) pace.tile_done(now += 10ms, 0.0302, 0.030, 0.010);
  EXPECT_EQ(pace.depth(), 3u);
}

// On a full link every tile under way makes the round trip longer.
TEST(SlavePace, AFullLinkDoesNotDrawEverMoreTiles) {
  SlavePace pace(1, SlavePace::kPrefetchAuto);
  constexpr double kTile = 0.010, kSend = 0.040, kEmptyLink = 0.041;
  TimePoint now{};
  pace.tile_done(now, kTile + kEmptyLink, kTile, kTile);
  for (int i = 0; i < 200; ++i) {
    const double round_trip = kEmptyLink + kSend * (pace.depth() - 1);
    pace.tile_done(now += 40ms, kTile + round_trip, kTile, kTile);
  }
  EXPECT_LT(pace.depth(), std::uint32_t{kTilesPerWorkerMax});
}

TEST(SlavePace, ATileLeasedNowIsBackAfterTheOnesBeforeIt) {
  const SlavePace pace = pace_of(2, 0.010, 0.004);
  EXPECT_NEAR(pace.completion_seconds(0, 1), 0.014, 1e-6);
  EXPECT_NEAR(pace.completion_seconds(1, 1), 0.014, 1e-6) << "a second thread is free";
  EXPECT_NEAR(pace.completion_seconds(5, 1), 0.034, 1e-6);
  EXPECT_NEAR(SlavePace(2, -1).completion_seconds(0, 0.5), 0.5, 1e-6) << "as others, until known";
}

TEST(SlavePace, WhateverASlaveReportsTheFiguresStayFinite) {
  constexpr double kBad[] = {std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(), -1, 1e308, 0};
  SlavePace pace(3, SlavePace::kPrefetchAuto);
  for (double a : kBad) {
    for (double b : kBad) {
      for (double c : kBad) {
        pace.tile_done({}, a, b, c);
        pace.round_trip_measured(a);
        EXPECT_GE(pace.depth(), 3u);
        EXPECT_LE(pace.depth(), 3u * kTilesPerWorkerMax);
        EXPECT_LE(pace.completion_seconds(3, 0), 4 * 3600);
        EXPECT_LE(pace.tiles_per_second(), 3e6);
      }
    }
  }
}

}  // namespace
}  // namespace tessera::master
