// SPDX-License-Identifier: Apache-2.0
// What slaves say of their tiles is cut to what can be true, and stays as it is where it can be.
#include "master/frame_loop/possible_figures.h"

#include <gtest/gtest.h>

#include <limits>

#include "master/schedule/lease_accounts.h"

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

wire::TileResult result_of(double seconds, double held, double starved, RayCounts rays) {
  wire::TileResult result;
  result.seconds = seconds;
  result.held_seconds = held;
  result.starved_seconds = starved;
  result.rays = rays;
  return result;
}

TEST(PossibleFigures, WhatCanBeTrueStays) {
  wire::TileResult result = result_of(0.5, 1, 30, {1024, 4096, 9000});
  cut_to_possible(1, 20, 2, result);
  EXPECT_EQ(result.seconds, 0.5);
  EXPECT_EQ(result.held_seconds, 1);
  EXPECT_EQ(result.starved_seconds, 30) << "two threads for up to 20 s";
  EXPECT_EQ(result.rays, (RayCounts{1024, 4096, 9000}));
}

TEST(PossibleFigures, NoTileTakesLongerThanItsLease) {
  constexpr auto kMany = std::numeric_limits<std::uint64_t>::max();
  for (const double lie : {1e300, std::numeric_limits<double>::infinity()}) {
    wire::TileResult result = result_of(lie, lie, lie, {kMany, kMany, kMany});
    cut_to_possible(0.25, 10, 4, result);
    EXPECT_EQ(result.seconds, 0.25);
    EXPECT_EQ(result.held_seconds, 0.25);
    EXPECT_EQ(result.starved_seconds, 40);
    EXPECT_EQ(result.rays.primary, 2'500'000'000u);
    EXPECT_EQ(result.rays.secondary, 2'500'000'000u);
  }
}

TEST(PossibleFigures, NonsenseIsNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  wire::TileResult result = result_of(nan, -1, nan, {1, 1, 1});
  cut_to_possible(0, -5, 1, result);
  EXPECT_EQ(result.seconds, 0);
  EXPECT_EQ(result.held_seconds, 0);
  EXPECT_EQ(result.starved_seconds, 0);
  EXPECT_EQ(result.rays.primary, 0u);
}

TEST(LeaseAccounts, KnowWhenALeaseWasGiven) {
  const TimePoint start{1000s};
  LeaseAccounts accounts;
  accounts.leased(1, 7, {3, 1}, start);
  accounts.leased(1, 7, {3, 2}, start + 1s);
  EXPECT_EQ(accounts.leased_at(1, 7, {3, 1}), start);
  EXPECT_EQ(accounts.leased_at(1, 7, {3, 2}), start + 1s);
  for (const auto& [session, frame] : {std::pair<SessionId, FrameId>{2, 7}, {1, 8}})
    EXPECT_EQ(accounts.leased_at(session, frame, {3, 1}), std::nullopt);
  accounts.answered(1, 7, {3, 1}, true);
  EXPECT_EQ(accounts.leased_at(1, 7, {3, 1}), std::nullopt);
}

}  // namespace
}  // namespace tessera::master
