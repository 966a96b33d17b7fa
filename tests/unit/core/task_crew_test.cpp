// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/task_crew.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "common/base/work_gate.h"
#include "slave/core/accel/run_tasks.h"

namespace tessera::core {
namespace {

// Counts the threads that work behind it.
class CountingGate : public WorkGate {
 public:
  std::atomic<int> inside{0}, most{0};

 private:
  void enter() override {
    const int now = ++inside;
    for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
    }
  }
  void leave() override { --inside; }
  void wait_turn() override {}
};

// Who has worked, and which threads they were.
struct Watch {
  std::mutex mutex;
  std::set<std::thread::id> threads;

  void note() {
    const std::lock_guard lock(mutex);
    threads.insert(std::this_thread::get_id());
  }
};

TEST(RunTasks, RunsEachTaskOnceForAllCounts) {
  const TaskCrew crew;
  for (int threads = 1; threads <= 5; ++threads) {
    for (const int count : {0, 1, 2, 3, 7, 64, 1000}) {
      std::vector<std::atomic<int>> runs(static_cast<std::size_t>(count));
      run_tasks(count, threads, [&](int i) { ++runs[static_cast<std::size_t>(i)]; });
      for (const std::atomic<int>& times : runs) ASSERT_EQ(times, 1) << count << " on " << threads;
    }
  }
}

TEST(RunTasks, OneThreadLeavesNoneOfTheOthersTasks) {
  // The first task of all waits until the others have run, though half of them are not its
  // thread's own.
  std::atomic<int> done{0};
  run_tasks(100, 2, [&](int i) {
    if (i == 0) {
      while (done < 99) std::this_thread::yield();
    }
    ++done;
  });
  EXPECT_EQ(done, 100);
}

TEST(TaskCrew, StretchesShareTheSameThreads) {
  Watch watch;
  const TaskCrew crew;
  for (int stretch = 0; stretch < 300; ++stretch) run_tasks(3, 3, [&](int) { watch.note(); });
  EXPECT_LE(watch.threads.size(), 3u);
}

TEST(TaskCrew, ThatOfTheCallerServesWhatItCalls) {
  Watch watch;
  const TaskCrew crew;
  for (int build = 0; build < 100; ++build) {
    const TaskCrew inner;
    run_tasks(2, 2, [&](int) { watch.note(); });
  }
  EXPECT_LE(watch.threads.size(), 2u);
}

TEST(TaskCrew, TasksMayRunTasksOfTheirOwn) {
  const TaskCrew crew;
  std::atomic<int> sum{0};
  run_tasks(4, 4, [&](int) { run_tasks(5, 3, [&](int i) { sum += i; }); });
  EXPECT_EQ(sum, 4 * 10);
}

TEST(TaskCrew, WhatATaskThrowsIsThrownAndTheCrewGoesOn) {
  const TaskCrew crew;
  for (int failing = 0; failing < 8; ++failing) {
    EXPECT_THROW(run_tasks(8, 3,
                           [&](int i) {
                             if (i == failing) throw std::runtime_error("a task fails");
                           }),
                 std::runtime_error);
    std::atomic<int> done{0};
    run_tasks(8, 3, [&](int) { ++done; });
    EXPECT_EQ(done, 8);
  }
}

TEST(TaskCrew, MembersWorkBehindTheCallersGateAndLeaveIt) {
  CountingGate gate;
  const WorkGate::Visit visit(&gate);
  const TaskCrew crew;
  std::atomic<int> here{0};
  run_tasks(3, 3, [&](int) {
    EXPECT_EQ(WorkGate::visited(), &gate);
    ++here;
    while (here < 3) std::this_thread::yield();
  });
  EXPECT_EQ(gate.most, 3);
  EXPECT_EQ(gate.inside, 1);
}

TEST(RunGrowing, ReachesAllThatWorkPutsIn) {
  for (int threads = 1; threads <= 4; ++threads) {
    std::atomic<int> leaves{0};
    run_growing(std::deque<int>{10}, threads, [&](int depth, const auto& put) {
      if (depth == 0) {
        ++leaves;
        return;
      }
      put(depth - 1);
      put(depth - 1);
    });
    EXPECT_EQ(leaves, 1024);
  }
}

TEST(WaitingItems, GoToWhoPutThemInNewestFirstAndTheOldestToOthers) {
  WaitingItems<int> waiting;
  for (int item = 0; item < 6; ++item) waiting.put(item, item % 2);
  EXPECT_EQ(waiting.take(1), 5);
  EXPECT_EQ(waiting.take(2), 0);
  EXPECT_EQ(waiting.take(0), 4);
  EXPECT_EQ(waiting.take(0), 2);
  EXPECT_EQ(waiting.take(0), 1);
  EXPECT_EQ(waiting.take(1), 3);
  EXPECT_TRUE(waiting.is_empty());
}

}  // namespace
}  // namespace tessera::core
