// SPDX-License-Identifier: Apache-2.0
#include "master/session/playback.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tessera {
namespace {

constexpr double kStepSeconds = 0.25;
constexpr double kForEver = std::numeric_limits<double>::infinity();

// Times are sums of powers of two, so that they are exact.
TimePoint at(double clock_seconds) { return TimePoint{} + from_seconds(clock_seconds); }

TEST(Playback, TheClockDecidesAndTheEndIsTheBeginning) {
  const Playback played(2, kStepSeconds, at(8));
  EXPECT_EQ(played.at(at(8)), 0);
  EXPECT_EQ(played.at(at(9.5)), 1.5);
  EXPECT_EQ(played.at(at(10)), 0);
  EXPECT_EQ(played.at(at(8 + 1000 + 0.5)), 0.5);
}

TEST(Playback, APauseHoldsTheMomentAndGoesOnFromIt) {
  Playback played(2, kStepSeconds, at(0));
  played.set_paused(true, at(0.75));
  EXPECT_TRUE(played.is_paused());
  EXPECT_EQ(played.at(at(100)), 0.75);
  played.set_paused(false, at(100));
  EXPECT_EQ(played.at(at(100.5)), 1.25);
}

TEST(Playback, StepsAreFramesAndGoRoundTheEnds) {
  Playback played(2, kStepSeconds, at(0));
  played.set_paused(true, at(0));
  played.step(3, at(1));
  EXPECT_EQ(played.at(at(2)), 0.75);
  played.step(-4, at(2));
  EXPECT_EQ(played.at(at(3)), 1.75);
  played.step(1, at(3));
  EXPECT_EQ(played.at(at(3)), 0);
}

TEST(Playback, WithoutAnEndItStopsAtItsBeginning) {
  Playback played(kForEver, kStepSeconds, at(0));
  EXPECT_EQ(played.at(at(1e6)), 1e6);
  played.set_paused(true, at(1));
  played.step(-10, at(1));
  EXPECT_EQ(played.at(at(1)), 0);
}

TEST(Playback, WhatDoesNotMoveIsAtZero) {
  Playback played(0, kStepSeconds, at(0));
  played.step(5, at(1));
  EXPECT_EQ(played.at(at(7)), 0);
}

TEST(Playback, AnotherSceneKeepsTheMomentWhereItHasIt) {
  Playback played(4, kStepSeconds, at(0));
  played.set_paused(true, at(3));
  played.set_duration(8, at(3));
  EXPECT_EQ(played.at(at(3)), 3);
  played.set_duration(2, at(3));
  EXPECT_EQ(played.at(at(3)), 1);
  played.set_duration(0, at(3));
  EXPECT_EQ(played.at(at(3)), 0);
}

TEST(Playback, AStepBackByLessThanARoundingIsNotTheEnd) {
  Playback played(2, 1e-300, at(0));
  played.set_paused(true, at(0));
  played.step(-1, at(0));
  EXPECT_LT(played.at(at(0)), 2);
}

}  // namespace
}  // namespace tessera
