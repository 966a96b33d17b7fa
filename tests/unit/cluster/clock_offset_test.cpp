// SPDX-License-Identifier: Apache-2.0
// The estimate of a peer's clock: planted offsets are found within the bound it states, whatever
// the two ways of the link take.
//
// A failing seed is printed.
#include "master/cluster/clock_offset.h"
#include "tests/support/seed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

const TimePoint kStart{1000s};

std::uint64_t theirs(TimePoint ours, std::int64_t offset_ns, double drift = 0) {
  const double since = 1e9 * seconds(ours - kStart);
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(tessera::nanoseconds(ours)) +
                                    offset_ns + static_cast<std::int64_t>(drift * since));
}

TEST(ClockOffset, NothingBeforeTheFirstSample) {
  EXPECT_FALSE(ClockOffset().estimate(kStart).has_value());
}

TEST(ClockOffset, EqualWaysGiveTheOffsetItself) {
  ClockOffset clock;
  clock.add(kStart, kStart + 2ms, theirs(kStart + 1ms, -5'000'000'000));
  EXPECT_EQ(clock.estimate(kStart + 2ms), (ClockEstimate{-5'000'000'000, 1'000'000}));
}

TEST(ClockOffset, TheTruthIsWithinTheBoundForAnySharesOfTheWay) {
  for (std::uint32_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(test::seed(seed));
    const auto pick = [&random](std::int64_t least, std::int64_t greatest) {
      return std::uniform_int_distribution<std::int64_t>(least, greatest)(random);
    };
    const std::int64_t offset = pick(-1'000'000'000'000, 1'000'000'000'000);
    const double drift = 1e-6 * static_cast<double>(pick(-100, 100));
    const std::int64_t there_least = pick(1'000, 20'000'000);  // one way is far slower
    const std::int64_t back_least = pick(1'000, 20'000'000);
    ClockOffset clock;
    TimePoint now = kStart;
    for (int i = 0; i < 100; ++i) {
      now += std::chrono::milliseconds(pick(1, 400));
      const TimePoint sent = now;
      now += nanoseconds(there_least + pick(0, 30'000'000));  // time in queues
      const std::uint64_t answered = theirs(now, offset, drift);
      now += nanoseconds(back_least + pick(0, 30'000'000));
      clock.add(sent, now, answered);
      const auto estimate = clock.estimate(now);
      ASSERT_TRUE(estimate.has_value());
      const double truth = static_cast<double>(offset) + drift * 1e9 * seconds(now - kStart);
      ASSERT_LE(std::abs(static_cast<double>(estimate->offset_ns) - truth),
                static_cast<double>(estimate->error_ns) + 2)  // 2: the divisions by two
          << "sample " << i;
    }
  }
}

TEST(ClockOffset, OneGoodSampleAmongNoisyOnesIsTaken) {
  ClockOffset clock;
  TimePoint now = kStart;
  for (int i = 0; i < 20; ++i) {
    const bool is_good = i == 7;
    const TimePoint sent = now;
    const Duration there = is_good ? Duration(50us) : Duration(30ms);
    now += there + 50us;
    clock.add(sent, now, theirs(sent + there, 42'000'000));
    now += 250ms;
  }
  const auto estimate = clock.estimate(now);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_EQ(estimate->offset_ns, 42'000'000);
  EXPECT_LT(estimate->error_ns, 1'000'000);  // 50 us and the drift of 3 s
}

TEST(ClockOffset, OldSamplesLoseAgainstNewOnes) {
  ClockOffset clock;
  clock.add(kStart, kStart + 100us, theirs(kStart + 50us, 1'000'000));
  const TimePoint later = kStart + 60s;  // 100 ppm of it are 6 ms
  clock.add(later, later + 2ms, theirs(later + 1ms, 3'000'000));
  EXPECT_EQ(clock.estimate(later + 2ms)->offset_ns, 3'000'000);
}

TEST(ClockOffset, HoldsFewSamplesAndLeavesOutNonsense) {
  ClockOffset clock;
  clock.add(kStart + 1ms, kStart, 5);
  EXPECT_FALSE(clock.estimate(kStart).has_value());
  clock.add(kStart, kStart + 10us, theirs(kStart + 5us, 7));
  for (std::size_t i = 0; i < ClockOffset::kSamplesMax; ++i)
    clock.add(kStart, kStart + 1ms, theirs(kStart + 500us, 9));
  EXPECT_EQ(clock.estimate(kStart + 1ms)->offset_ns, 9);  // the first sample was dropped
  clock.add(kStart, kStart + 1ns, ~std::uint64_t{0});     // the difference wraps, without overflow
}

}  // namespace
}  // namespace tessera::master
