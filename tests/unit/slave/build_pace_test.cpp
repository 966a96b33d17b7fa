// SPDX-License-Identifier: Apache-2.0
#include "slave/build_pace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace tessera::slave {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr TimePoint kBegin{std::chrono::seconds(1)};

// Threads of a build that ask every 100 microseconds, for `span`.
// Returns: the processor time that they took, in seconds.
double taken(BuildPace& pace, int threads, TimePoint& now, Duration span) {
  constexpr Duration kStep = microseconds(100);
  std::vector<bool> runs(static_cast<std::size_t>(threads), true);
  for (int t = 0; t < threads; ++t) pace.enter(now);
  double sum = 0;
  for (const TimePoint end = now + span; now < end; now += kStep) {
    for (std::size_t t = 0; t < runs.size(); ++t) {
      runs[t] = runs[t] ? pace.goes_on(now) : pace.resumes(now);
      if (runs[t]) sum += seconds(kStep);
    }
  }
  return sum;
}

TEST(BuildPaceTest, AllThreadsRunWhereNothingIsRendered) {
  BuildPace pace(8);
  TimePoint now = kBegin;
  EXPECT_NEAR(taken(pace, 8, now, milliseconds(100)), 0.8, 1e-9);
  EXPECT_FALSE(pace.is_narrow());
}

TEST(BuildPaceTest, AThreadRunsForEachRenderThreadWithoutATile) {
  BuildPace pace(8, 0);
  TimePoint now = kBegin;
  pace.set_rendering(5, now);
  EXPECT_NEAR(taken(pace, 8, now, milliseconds(100)), 0.3, 1e-9);
}

TEST(BuildPaceTest, WhereAllRenderABuildGetsItsShareAndNotMore) {
  for (const int processors : {1, 2, 16, 64}) {
    for (const int threads : {1, processors}) {
      BuildPace pace(processors);
      TimePoint now = kBegin;
      pace.set_rendering(processors, now);
      const double expected =
          std::min(BuildPace::kShare * processors, static_cast<double>(threads));
      EXPECT_NEAR(taken(pace, threads, now, std::chrono::seconds(2)) / 2, expected, 0.02 * expected)
          << processors << " processors, " << threads << " threads";
    }
  }
}

// A part of a build that does not ask is paid for afterwards.
TEST(BuildPaceTest, WhatWasTakenTooMuchIsOwed) {
  BuildPace pace(2);
  pace.set_rendering(2, kBegin);
  pace.enter(kBegin);
  EXPECT_FALSE(pace.goes_on(kBegin + milliseconds(100)));
  EXPECT_FALSE(pace.resumes(kBegin + milliseconds(700)));
  EXPECT_TRUE(pace.resumes(kBegin + milliseconds(1000)));
}

TEST(BuildPaceTest, AFreeProcessorIsTakenAtOnceWhateverIsOwed) {
  BuildPace pace(2);
  pace.set_rendering(2, kBegin);
  pace.enter(kBegin);
  TimePoint now = kBegin + milliseconds(500);
  EXPECT_FALSE(pace.goes_on(now));
  EXPECT_FALSE(pace.resumes(now));
  pace.set_rendering(1, now);
  EXPECT_TRUE(pace.resumes(now));
  pace.set_rendering(2, now);
  EXPECT_FALSE(pace.goes_on(now + microseconds(100)));
  EXPECT_EQ(pace.running(), 0);
}

TEST(BuildPaceTest, WhoWaitsIsToldWhenToAsk) {
  BuildPace pace(2);
  pace.set_rendering(2, kBegin);
  pace.enter(kBegin);
  TimePoint now = kBegin + milliseconds(5);
  EXPECT_FALSE(pace.goes_on(now));
  int asked = 0;
  for (; !pace.resumes(now); ++asked) {
    EXPECT_GT(pace.next_turn(now), now);
    now = pace.next_turn(now);
  }
  EXPECT_LE(asked, 3);
}

}  // namespace
}  // namespace tessera::slave
