// SPDX-License-Identifier: Apache-2.0
// The limiter of log lines passes some of them, counts the others, and keeps its memory bounded.
#include "common/base/log_limiter.h"

#include <gtest/gtest.h>

#include "common/base/log.h"

namespace tessera {
namespace {

using namespace std::chrono_literals;
const TimePoint kStart{100s};

TEST(LogLimiter, PassesTheFirstLinesOfEachEventAndSumsUpTheRest) {
  LogLimiter limiter(3, 10s);
  int passed = 0;
  for (int i = 0; i < 60; ++i) passed += limiter.admit("slave-lost", kStart + 1ms * i);
  EXPECT_EQ(passed, 3);
  EXPECT_TRUE(limiter.admit("slave-joined", kStart + 1s)) << "another event is not held up";
  EXPECT_TRUE(limiter.summaries(kStart + 9s).empty()) << "the interval is not over";
  const auto summaries = limiter.summaries(kStart + 10s);
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_EQ(summaries[0].event, "slave-lost");
  EXPECT_EQ(summaries[0].suppressed, 57u);
  EXPECT_DOUBLE_EQ(summaries[0].seconds, 10);
  EXPECT_FALSE(limiter.has_suppressed());
  EXPECT_TRUE(limiter.admit("slave-lost", kStart + 10s)) << "a new interval";
}

TEST(LogLimiter, WhatWasEverSuppressedIsKnownByName) {
  LogLimiter limiter(3, 10s);
  for (int i = 0; i < 60; ++i) (void)limiter.admit("slave-lost", kStart + 1ms * i);
  (void)limiter.admit("slave-joined", kStart);
  for (const auto later : {11s, 22s}) {
    EXPECT_EQ(limiter.summaries(kStart + later).size(), 1u);
    for (int i = 0; i < 5; ++i) (void)limiter.admit("slave-lost", kStart + later);
  }
  const auto ever = limiter.ever_suppressed();
  ASSERT_EQ(ever.size(), 1u) << "an event of which all lines were written has nothing to say";
  EXPECT_EQ(ever[0], (SuppressedLines{"slave-lost", 57 + 2 + 2}));
}

TEST(EventMemory, KeepsTheLastHundredLinesAndTheirAge) {
  EventMemory memory;
  for (int i = 0; i < 250; ++i)
    memory.add(3, "event " + std::to_string(i) + std::string(1000, '.'), kStart + 1s * i);
  const auto events = memory.events(kStart + 250s);
  ASSERT_EQ(events.size(), EventMemory::kEventsKept);
  EXPECT_TRUE(events.front().line.starts_with("event 150."));
  EXPECT_TRUE(events.back().line.starts_with("event 249."));
  EXPECT_DOUBLE_EQ(events.back().seconds_ago, 1);
  EXPECT_EQ(events.back().line.size(), EventMemory::kLineBytesMax);
}

TEST(LogLimiter, SlowEventsAllPass) {
  LogLimiter limiter(2, 10s);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(limiter.admit("tick", kStart + 6s * i));
}

TEST(LogLimiter, EveryLineIsWrittenOrCounted) {
  LogLimiter limiter(5, 10s);
  std::uint64_t written = 0, counted = 0;
  TimePoint now = kStart;
  for (int i = 0; i < 5000; ++i) {
    now += std::chrono::milliseconds(i % 37);
    written += limiter.admit(i % 3 == 0 ? "a" : "b", now) ? 1 : 0;
    for (const auto& summary : limiter.summaries(now)) counted += summary.suppressed;
  }
  for (const auto& summary : limiter.summaries(now, true)) counted += summary.suppressed;
  EXPECT_EQ(written + counted, 5000u);
  EXPECT_GT(counted, 1000u);
}

TEST(LogLimiter, ManyEventsShareOneAccountAtTheBound) {
  LogLimiter limiter(1, 10s);
  std::uint64_t passed = 0;
  for (int i = 0; i < 10'000; ++i) passed += limiter.admit("e" + std::to_string(i), kStart) ? 1 : 0;
  EXPECT_LE(passed, LogLimiter::kEventsMax + 1);
  EXPECT_LE(limiter.summaries(kStart + 10s).size(), LogLimiter::kEventsMax + 1);
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != text.npos; at += part.size()) ++count;
  return count;
}

TEST(Log, AFloodOfOneEventIsAFewLinesAndASum) {
  testing::internal::CaptureStderr();
  for (int i = 0; i < kLogLinesMax + 57; ++i) log_warn("slave-lost", "slave 'a' is gone");
  log_warn("frame-failed", "another event is not held up");
  log_summaries(/*is_last=*/true);
  log_summaries(/*is_last=*/true);
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(count_of(text, "slave 'a' is gone"), static_cast<std::size_t>(kLogLinesMax)) << text;
  EXPECT_EQ(count_of(text, "slave-lost: ... and 57 more in 0 s"), 1u) << text;
  EXPECT_EQ(count_of(text, "frame-failed: another"), 1u) << text;
}

}  // namespace
}  // namespace tessera
