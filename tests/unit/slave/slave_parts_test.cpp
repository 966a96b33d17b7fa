// SPDX-License-Identifier: Apache-2.0
// The pure parts of a slave: starvation; and the tile queue.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "common/base/limits.h"
#include "slave/tile_queue.h"
#include "tests/support/asleep.h"

namespace tessera::slave {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

TEST(StarvationClock, CountsWaitingWorkersWhileFramesAreOpen) {
  StarvationClock clock;
  const TimePoint t0 = TimePoint{} + 1h;
  clock.set_waiting(2, t0);
  clock.set_open_frames(1, t0 + 10s);  // the 10 s before do not count
  clock.set_waiting(3, t0 + 11s);      // 2 x 1 s
  clock.set_open_frames(2, t0 + 12s);  // 3 x 1 s
  clock.set_open_frames(0, t0 + 13s);  // 3 x 1 s
  EXPECT_DOUBLE_EQ(clock.take(t0 + 20s), 8.0);
  EXPECT_DOUBLE_EQ(clock.take(t0 + 30s), 0.0);
}

std::shared_ptr<FrameWork> frame(FrameId id) {
  return std::make_shared<FrameWork>(wire::FrameBegin{id, 1, Isa::kScalar, {}}, nullptr, 1);
}

TEST(TileQueue, FirstInFirstOutBoundedAndRemovableByFrame) {
  TileQueue queue(3);
  const auto a = frame(1);
  const auto b = frame(2);
  EXPECT_TRUE(queue.try_push({a, 0, 1, {}}));
  EXPECT_TRUE(queue.try_push({b, 1, 1, {}}));
  EXPECT_TRUE(queue.try_push({a, 2, 1, {}}));
  EXPECT_FALSE(queue.try_push({a, 3, 1, {}})) << "full";
  EXPECT_EQ(queue.pop()->tile, 0u);
  const auto removed = queue.remove_frame(a.get());
  ASSERT_EQ(removed.size(), 1u);
  EXPECT_EQ(removed[0].tile, 2u);
  EXPECT_EQ(queue.pop()->tile, 1u);
  EXPECT_TRUE(queue.try_push({b, 4, 1, {}}));
  queue.close();
  EXPECT_FALSE(queue.try_push({b, 5, 1, {}})) << "closed";
  EXPECT_EQ(queue.pop()->tile, 4u);
  EXPECT_FALSE(queue.pop().has_value());
}

TEST(TileQueue, ALateTileOfAnOlderFrameGoesAheadOfTheNextFrame) {
  TileQueue queue(4);
  const auto older = frame(1), newer = frame(2);
  EXPECT_TRUE(queue.try_push({older, 0, 1, {}}));
  EXPECT_TRUE(queue.try_push({newer, 1, 1, {}}));
  EXPECT_TRUE(queue.try_push({older, 2, 1, {}}));
  EXPECT_TRUE(queue.try_push({newer, 3, 1, {}}));
  for (const TileIndex tile : {0u, 2u, 1u, 3u}) EXPECT_EQ(queue.pop()->tile, tile);
}

// Clock of the process while a HandClock lives; only the test moves it on.
class HandClock {
 public:
  HandClock() {
    Clock::set_source([] { return TimePoint{Duration(now_.load())}; });
  }
  ~HandClock() { Clock::set_source(nullptr); }
  void advance(Duration time) { now_ += time.count(); }

 private:
  static inline std::atomic<Clock::rep> now_{0};
};

TEST(TileQueue, WaitingForTilesOfAnOpenFrameIsStarved) {
  HandClock clock;
  TileQueue queue(2);
  queue.set_open_frames(1);
  std::thread worker([&queue] { EXPECT_TRUE(queue.pop().has_value()); });
  do {  // until the worker waits
    std::this_thread::yield();
    clock.advance(1s);
  } while (queue.take_starved_seconds() == 0);
  clock.advance(50s);
  EXPECT_TRUE(queue.try_push({frame(1), 0, 1, {}}));
  worker.join();
  EXPECT_DOUBLE_EQ(queue.take_starved_seconds(), 50);
  clock.advance(7s);
  EXPECT_EQ(queue.take_starved_seconds(), 0) << "nobody waits any more";
}

TEST(TileQueue, TellsHowManyWaitForATile) {
  std::atomic<int> waiting = -1;
  TileQueue queue(2, [&waiting](int workers) { waiting = workers; });
  EXPECT_TRUE(queue.try_push({frame(1), 0, 1, {}}));
  EXPECT_TRUE(queue.pop().has_value());
  EXPECT_EQ(waiting, -1) << "nobody had to wait";
  std::thread worker([&queue] { EXPECT_TRUE(queue.pop().has_value()); });
  while (waiting != 1) std::this_thread::yield();
  EXPECT_TRUE(queue.try_push({frame(1), 1, 1, {}}));
  worker.join();
  EXPECT_EQ(waiting, 0);
}

TEST(TileQueue, CloseWakesSleepers) {
  TileQueue queue(1);
  test::WatchedThread sleeper([&queue] { EXPECT_FALSE(queue.pop().has_value()); });
  sleeper.wait_until_asleep();
  queue.close();
  sleeper.join();
}

}  // namespace
}  // namespace tessera::slave
