// SPDX-License-Identifier: Apache-2.0
// A trace is bounded. The times in its file have the offsets between clocks removed, and no span
// overlaps another one of its row.
#include "master/frame_loop/trace.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <iterator>

namespace tessera::master {
namespace {

using namespace std::chrono_literals;

const TimePoint kStart{500s};
constexpr std::int64_t kOffset = -123'456'789'000;  // the slave's clock is two minutes behind

TracedTile tile_at(SessionId session, FrameId frame, std::uint32_t tile, TimePoint began) {
  TracedTile t;
  t.session = session;
  t.frame = frame;
  t.tile = tile;
  t.attempt = 1;
  t.received = began + 12ms;
  t.began_ns = static_cast<std::uint64_t>(static_cast<std::int64_t>(nanoseconds(began)) + kOffset);
  t.render_seconds = 0.01;
  t.is_accepted = true;
  return t;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Trace, TakesClockOffsetsOut) {
  TraceRecorder recorder(kStart);
  recorder.slave_joined(7, "far \"away\"", 2);
  recorder.leased(7, 3, 5, 1, kStart + 1ms);
  recorder.answered(tile_at(7, 3, 5, kStart + 4ms), ClockEstimate{kOffset, 250'000});
  recorder.frame_over({3, 9, kStart, kStart + 20ms, "done"});
  const std::string text = trace_json(recorder.take());
  EXPECT_TRUE(has(text, R"("ph":"X","pid":2,"tid":0,"ts":4000.000,"dur":10000.000)")) << text;
  EXPECT_TRUE(has(text, R"("ph":"X","pid":1,"tid":0,"ts":0.000,"dur":20000.000)")) << text;
  EXPECT_TRUE(has(text, R"("ph":"b","cat":"lease","id":1,"pid":1,"tid":0,"ts":1000.000)")) << text;
  EXPECT_TRUE(has(text, R"("ph":"e","cat":"lease","id":1,"pid":1,"tid":0,"ts":16000.000)")) << text;
  EXPECT_TRUE(has(text, R"("waited_us":3000,"returned_us":2000)")) << text;
  EXPECT_TRUE(has(text, R"("labels":"clock within 250.000 us of the master's")")) << text;
  EXPECT_TRUE(has(text, R"("clock_error_us":{"2":250.000})")) << text;
}

TEST(Trace, FramesThatOverlapGetRowsOfTheirOwn) {
  TraceRecorder recorder(kStart);
  recorder.frame_over({0, 1, kStart, kStart + 10ms, "done"});
  recorder.frame_over({1, 1, kStart + 5ms, kStart + 15ms, "done"});
  recorder.frame_over({2, 1, kStart + 10ms, kStart + 20ms, "failed"});
  const std::string text = trace_json(recorder.take());
  EXPECT_TRUE(has(text, R"("pid":1,"tid":0,"ts":0.000)")) << text;
  EXPECT_TRUE(has(text, R"("pid":1,"tid":1,"ts":5000.000)")) << text;
  EXPECT_TRUE(has(text, R"("pid":1,"tid":0,"ts":10000.000)")) << text;
}

// What a slave built ends when the master hears of it; two messages may come at once.
TEST(Trace, BuildsHaveARowBelowTheRenderThreads) {
  TraceRecorder recorder(kStart);
  recorder.slave_joined(7, "a", 2);
  recorder.leased(7, 3, 5, 1, kStart);
  recorder.answered(tile_at(7, 3, 5, kStart), ClockEstimate{kOffset, 0});
  recorder.built({7, 4, kStart + 10ms, 0.006, 12});
  recorder.built({7, 5, kStart + 12ms, 0.004, 0});
  recorder.built({8, 5, kStart + 12ms, 0.004, 0});  // of no slave that is known
  const std::string text = trace_json(recorder.take());
  EXPECT_TRUE(has(text, R"("pid":2,"tid":2,"name":"thread_name","args":{"name":"builder"})"));
  EXPECT_TRUE(has(text, R"("pid":2,"tid":2,"ts":4000.000,"dur":6000.000,"name":"scene 4")"));
  EXPECT_TRUE(has(text, R"("pid":2,"tid":2,"ts":10000.000,"dur":2000.000,"name":"scene 5")"));
  EXPECT_TRUE(has(text, R"({"scene_version":4,"built_primitives":12})")) << text;
  EXPECT_FALSE(has(text, R"("pid":3)"));
}

// A scene is under way from when the master has it until its build begins; the slave takes one
// after the other.
TEST(Trace, TransfersHaveARowBelowTheBuilds) {
  TraceRecorder recorder(kStart);
  recorder.slave_joined(7, "a", 2);
  recorder.leased(7, 3, 5, 1, kStart);
  recorder.answered(tile_at(7, 3, 5, kStart), ClockEstimate{kOffset, 0});
  recorder.built({7, 4, kStart + 10ms, 0.002, 12, kStart - 1ms});
  recorder.built({7, 5, kStart + 18ms, 0.004, 0, kStart + 5ms});
  recorder.built({7, 6, kStart + 19ms, 0.001, 0});  // nobody knows since when
  const std::string text = trace_json(recorder.take());
  EXPECT_TRUE(
      has(text, R"("pid":2,"tid":3,"name":"thread_name","args":{"name":"scene transfer"})"));
  EXPECT_TRUE(has(text, R"("pid":2,"tid":3,"ts":0.000,"dur":9000.000,"name":"scene 4")")) << text;
  EXPECT_TRUE(has(text, R"("pid":2,"tid":3,"ts":9000.000,"dur":6000.000,"name":"scene 5")"))
      << text;
  EXPECT_FALSE(has(text, R"("pid":2,"tid":3,"ts":19000.000)"));
}

TEST(Trace, WithoutAClockTilesAreLeftOutAndCounted) {
  TraceRecorder recorder(kStart);
  recorder.slave_joined(7, "old", 1);
  recorder.leased(7, 0, 0, 1, kStart);
  recorder.answered(tile_at(7, 0, 0, kStart), std::nullopt);
  const std::string text = trace_json(recorder.take());
  EXPECT_TRUE(has(text, R"("tiles_without_clock":1)"));
  EXPECT_FALSE(has(text, R"("pid":2)"));
}

TEST(Trace, TheBestClockOfASessionIsKept) {
  TraceRecorder recorder(kStart);
  recorder.slave_joined(7, "a", 1);
  const std::int64_t errors[] = {500, 100, 900};
  for (std::uint32_t i = 0; i < 3; ++i) {
    recorder.leased(7, 0, i, 1, kStart);
    recorder.answered(tile_at(7, 0, i, kStart), ClockEstimate{kOffset, errors[i]});
  }
  EXPECT_EQ(recorder.take().slaves.at(7).clock->error_ns, 100);
}

// A build that was told first began before that, and a slave may say that it took any time.
TEST(Trace, BeginsWithTheFirstBuild) {
  TraceRecorder recorder(kStart);
  recorder.slave_joined(7, "a", 1);
  recorder.built({7, 1, kStart, 0.25, 12});
  EXPECT_EQ(recorder.take().start, kStart - 250ms);
  TraceRecorder lied_to(kStart);
  lied_to.slave_joined(7, "a", 1);
  lied_to.built({7, 1, kStart, 1e300, 12});
  EXPECT_EQ(lied_to.take().start, kStart - 24h);
}

TEST(Trace, KeepsOnlyAnswersToLeasesItWasToldOf) {
  TraceRecorder recorder(kStart);
  recorder.slave_joined(7, "a", 1);
  for (std::uint32_t i = 0; i < 3; ++i) recorder.leased(7, i, 0, 1, kStart);
  recorder.frame_ended(7, 0);
  recorder.answered(tile_at(7, 0, 0, kStart), std::nullopt);  // its frame is over
  recorder.answered(tile_at(7, 1, 1, kStart), std::nullopt);  // tile 1 was not leased
  recorder.answered(tile_at(7, 1, 0, kStart), std::nullopt);
  recorder.answered(tile_at(7, 1, 0, kStart), std::nullopt);  // a second answer
  recorder.slave_lost(7);
  recorder.answered(tile_at(7, 2, 0, kStart), std::nullopt);
  EXPECT_EQ(recorder.take().tiles.size(), 1u);
}

TEST(Trace, IsBounded) {
  TraceRecorder recorder(kStart);
  recorder.slave_joined(7, "a", 1);
  for (std::uint32_t i = 0; i < TraceRecorder::kTilesMax + 5; ++i) {
    recorder.leased(7, 0, i, 1, kStart);
    recorder.answered(tile_at(7, 0, i, kStart), std::nullopt);
  }
  for (SessionId s = 100; s < 100 + 2 * TraceRecorder::kSlavesMax; ++s) {
    recorder.slave_joined(s, "come and gone", 1);
    recorder.slave_lost(s);
  }
  for (SceneVersion v = 0; v < TraceRecorder::kFramesMax + 3; ++v)
    recorder.built({7, v, kStart, 0.001, 0});
  const Trace trace = recorder.take();
  EXPECT_EQ(trace.builds.size(), TraceRecorder::kFramesMax);
  EXPECT_EQ(trace.builds_dropped, 3u);
  EXPECT_EQ(trace.tiles.size(), TraceRecorder::kTilesMax);
  EXPECT_EQ(trace.tiles.front().tile, 5u);  // the oldest were dropped
  EXPECT_EQ(trace.tiles_dropped, 5u);
  EXPECT_LE(trace.slaves.size(), TraceRecorder::kSlavesMax);
  EXPECT_TRUE(trace.slaves.contains(7));
}

TEST(Trace, AFileThatCannotBeWrittenIsNamed) {
  const Status status = write_trace(Trace(), "/no/such/folder/t.json");
  EXPECT_FALSE(status.is_ok());
  EXPECT_TRUE(has(status.message(), "/no/such/folder/t.json"));
}

}  // namespace
}  // namespace tessera::master
