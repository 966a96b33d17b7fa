// SPDX-License-Identifier: Apache-2.0
// Which slaves are held back, for how long, and which are not.
#include "master/cluster/quarantine.h"

#include <gtest/gtest.h>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint kStart = TimePoint{} + 24h;

TEST(Quarantine, ASlaveThatCrashesAgainAndAgainIsHeldBackForAGrowingTime) {
  Quarantine quarantine;
  TimePoint now = kStart;
  Duration last{};
  for (int round = 0; round < 8; ++round) {
    for (std::size_t i = 1; i < Quarantine::kLossesMax; ++i) {
      EXPECT_FALSE(quarantine.count_loss("a", 0, 1, 4, now += 1s));
      EXPECT_FALSE(quarantine.find("a", now));
    }
    EXPECT_TRUE(quarantine.count_loss("a", 0, 1, 4, now += 1s));
    const auto held = quarantine.find("a", now);
    ASSERT_TRUE(held);
    EXPECT_GE(held->seconds, 30);
    EXPECT_EQ(held->times, static_cast<std::uint32_t>(round + 1));
    const Duration length = from_seconds(held->seconds);
    EXPECT_TRUE(length > last || length == Duration(Quarantine::kLongest));
    last = length;
    EXPECT_TRUE(quarantine.find("a", now + length - 1ms));
    EXPECT_FALSE(quarantine.find("a", now += length));
  }
  EXPECT_EQ(last, Duration(Quarantine::kLongest));
}

TEST(Quarantine, LossesFarApartDoNotCountTogether) {
  Quarantine quarantine;
  for (int i = 0; i < 50; ++i) {
    EXPECT_FALSE(quarantine.count_loss("a", 0, 0, 4, kStart + i * 31s));
  }
}

TEST(Quarantine, ASlaveThatBringsWhatItCostsIsNotHeldBack) {
  Quarantine quarantine;
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(quarantine.count_loss("restarted by hand", 0, 4, 4, kStart + i * 1s));
    EXPECT_FALSE(quarantine.count_loss("idle", 0, 0, 0, kStart + i * 1s));
  }
  EXPECT_TRUE(quarantine.entries(kStart + 100s).empty());
}

TEST(Quarantine, AProcessThatComesBackWasLostForItsLink) {
  Quarantine quarantine;
  for (int reset = 0; reset < 20; ++reset) {
    const TimePoint now = kStart + reset * 2s;
    EXPECT_FALSE(quarantine.count_loss("a", 77, 0, 4, now)) << reset;
    quarantine.forget_losses("a", 77, now + 1s);
  }
  EXPECT_FALSE(quarantine.count_loss("a", 77, 0, 4, kStart + 50s));
  EXPECT_FALSE(quarantine.count_loss("a", 78, 0, 4, kStart + 51s));
  EXPECT_TRUE(quarantine.count_loss("a", 79, 0, 4, kStart + 52s)) << "three processes";
  quarantine.forget_losses("a", 0, kStart + 53s);
  quarantine.forget_losses("a", 80, kStart + 53s);
  EXPECT_TRUE(quarantine.find("a", kStart + 53s)) << "those are other processes";
  quarantine.forget_losses("a", 79, kStart + 53s);
  EXPECT_FALSE(quarantine.find("a", kStart + 53s)) << "it was not the process that ended";
  EXPECT_TRUE(quarantine.count_loss("a", 79, 0, 4, kStart + 54s)) << "the two others still count";
  EXPECT_EQ(quarantine.find("a", kStart + 54s)->times, 1u);
}

TEST(Quarantine, AProcessThatComesBackIsStillHeldBackForWhatItSent) {
  Quarantine quarantine;
  quarantine.count_violation("a", "lies", kStart);
  quarantine.forget_losses("a", 77, kStart + 1s);
  EXPECT_TRUE(quarantine.find("a", kStart + 1s));
}

TEST(Quarantine, WrongPixelsCountWithinAMinute) {
  Quarantine quarantine;
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(quarantine.count_wrong("a", kStart + i * 31s));
  EXPECT_FALSE(quarantine.count_wrong("b", kStart));
  EXPECT_FALSE(quarantine.count_wrong("b", kStart + 1s));
  EXPECT_TRUE(quarantine.count_wrong("b", kStart + 2s));
}

TEST(Quarantine, AViolationHoldsBackAtOnceAndOnlyWhoDidIt) {
  Quarantine quarantine;
  quarantine.count_violation("liar", "a tile result of the wrong size", kStart);
  EXPECT_FALSE(quarantine.find("honest", kStart));
  const auto held = quarantine.find("liar", kStart + 10s);
  ASSERT_TRUE(held);
  EXPECT_DOUBLE_EQ(held->seconds, 20);
  EXPECT_EQ(held->reason, "a tile result of the wrong size");
  ASSERT_EQ(quarantine.entries(kStart).size(), 1u);
  EXPECT_TRUE(quarantine.entries(kStart + 31s).empty());
}

TEST(Quarantine, AnHourWithoutOffenceMakesItAnew) {
  Quarantine quarantine;
  for (int i = 0; i < 4; ++i) quarantine.count_violation("a", "lies", kStart);
  EXPECT_DOUBLE_EQ(quarantine.find("a", kStart)->seconds, 240);
  const TimePoint later = kStart + Quarantine::kForgiven + 1s;
  quarantine.count_violation("a", "lies", later);
  EXPECT_DOUBLE_EQ(quarantine.find("a", later)->seconds, 30);
}

TEST(Quarantine, NamesAreForgottenOldestFirst) {
  Quarantine quarantine;
  for (std::size_t i = 0; i <= Quarantine::kNamesMax; ++i) {
    quarantine.count_violation("s" + std::to_string(i), "lies", kStart + i * 1us);
  }
  const TimePoint now = kStart + 1s;
  EXPECT_EQ(quarantine.entries(now).size(), Quarantine::kNamesMax);
  EXPECT_FALSE(quarantine.find("s0", now));
  EXPECT_TRUE(quarantine.find("s" + std::to_string(Quarantine::kNamesMax), now));
}

}  // namespace
}  // namespace tessera::master
