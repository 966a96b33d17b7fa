// SPDX-License-Identifier: Apache-2.0
// How fast an address may open connections.
#include "common/net/accept_rate.h"
#include "tests/support/seed.h"

#include <gtest/gtest.h>

#include <random>

namespace tessera::net {
namespace {

using namespace std::chrono_literals;

const TimePoint kStart = TimePoint{} + 1000s;

int admitted(AcceptRate& rate, const std::string& address, TimePoint now, int tries) {
  int count = 0;
  for (int i = 0; i < tries; ++i) count += rate.admit(address, now) ? 1 : 0;
  return count;
}

TEST(AcceptRate, ABurstPassesAndThenSoManyASecond) {
  AcceptRate rate({.burst = 20, .per_second = 10});
  EXPECT_EQ(admitted(rate, "a", kStart, 100), 20);
  EXPECT_EQ(admitted(rate, "a", kStart + 50ms, 100), 0);
  EXPECT_EQ(admitted(rate, "a", kStart + 100ms, 100), 1);
  EXPECT_EQ(admitted(rate, "a", kStart + 2100ms, 100), 20);
  EXPECT_EQ(admitted(rate, "a", kStart + 1h, 100), 20) << "no more than a burst is saved up";
}

TEST(AcceptRate, OneAddressCostsAnotherNothing) {
  AcceptRate rate({.burst = 5, .per_second = 1});
  EXPECT_EQ(admitted(rate, "flood", kStart, 1000), 5);
  EXPECT_EQ(admitted(rate, "slave", kStart, 5), 5);
}

TEST(AcceptRate, FiveHundredSlavesOnOneMachineComeAtOnce) {
  AcceptRate rate;
  EXPECT_EQ(admitted(rate, "127.0.0.1", kStart, 2 * 500), 2 * 500);
}

TEST(AcceptRate, InNoIntervalMoreThanTheBurstAndTheRate) {
  std::mt19937 chance(test::seed(7));
  AcceptRate rate({.burst = 8, .per_second = 50});
  std::vector<TimePoint> times;
  TimePoint now = kStart;
  for (int i = 0; i < 5000; ++i) {
    now += std::chrono::microseconds(std::uniform_int_distribution<>(0, 8000)(chance));
    if (rate.admit("a", now)) times.push_back(now);
  }
  for (std::size_t first = 0; first < times.size(); first += 37) {
    for (std::size_t last = first; last < times.size(); ++last) {
      ASSERT_LE(static_cast<double>(last - first + 1),
                8 + 50 * seconds(times[last] - times[first]) + 1e-6);  // sums of 5,000 roundings
    }
  }
}

TEST(AcceptRate, TheTableIsBoundedAndWhatIsBeyondSharesOneBucket) {
  AcceptRate rate({.burst = 4, .per_second = 1, .addresses_max = 10});
  for (int i = 0; i < 10; ++i) EXPECT_EQ(admitted(rate, std::to_string(i), kStart, 9), 4);
  int beyond = 0;
  for (int i = 10; i < 1000; ++i) beyond += admitted(rate, std::to_string(i), kStart, 9);
  EXPECT_EQ(beyond, 4);
  EXPECT_EQ(rate.address_count(), 10u);
  // Once the buckets of earlier addresses are full again, the table has room.
  EXPECT_EQ(admitted(rate, "later", kStart + 10s, 9), 4);
  EXPECT_EQ(rate.address_count(), 1u);
}

}  // namespace
}  // namespace tessera::net
