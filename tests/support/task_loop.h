// SPDX-License-Identifier: Apache-2.0
// An event loop without a thread: what is posted runs when the test says so, in order.
//
// Threads. The test's one.
#pragma once

#include <deque>
#include <functional>
#include <initializer_list>
#include <memory>
#include <utility>

#include "common/base/check.h"
#include "common/net/event_loop.h"

namespace tessera::test {

class TaskLoop final : public net::EventLoop {
 public:
  void post(std::function<void()> task) override { tasks_.push_back(std::move(task)); }
  void run_and_wait(std::function<void()> task) override { task(); }
  bool is_current() const override { return true; }
  // Time does not pass here; tests that need timers belong into tests/sim.
  std::unique_ptr<net::TimerBackend> make_timer() override {
    TESSERA_CHECK(false);
    return nullptr;
  }

  // Returns: whether there was a task to run.
  bool step() {
    if (tasks_.empty()) return false;
    auto task = std::move(tasks_.front());
    tasks_.pop_front();
    task();
    return true;
  }

 private:
  std::deque<std::function<void()>> tasks_;
};

// Runs one task of each loop in turns, until none has any.
inline void run_until_idle(std::initializer_list<TaskLoop*> loops) {
  for (bool has_run = true; has_run;) {
    has_run = false;
    for (TaskLoop* loop : loops) has_run |= loop->step();
  }
}

}  // namespace tessera::test
