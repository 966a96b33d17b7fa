// SPDX-License-Identifier: Apache-2.0
// One thread's loop of events: tasks in the order of posting, and timers. Every protocol object
// belongs to exactly one loop and is touched on it alone.
//
// Two implementations: IoThread (Asio, real time) and the one of tests/sim (virtual time, many
// machines in one thread).
//
// Threads. As each function says.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

namespace tessera::net {

// Implementation of a Timer for one kind of loop. Loop's thread only. After cancel() the callback
// does not run; another start() replaces it.
class TimerBackend {
 public:
  virtual ~TimerBackend() = default;  // cancels
  // `interval` 0: the timer fires once.
  virtual void start(std::chrono::milliseconds delay, std::chrono::milliseconds interval,
                     std::function<void()> callback) = 0;
  virtual void cancel() = 0;
};

class EventLoop {
 public:
  virtual ~EventLoop() = default;

  // Runs `task` on the loop's thread, in order of posting. Any thread. The task is dropped when the
  // loop has ended.
  virtual void post(std::function<void()> task) = 0;

  // Runs `task` on the loop's thread and waits for it; directly when called on that thread.
  virtual void run_and_wait(std::function<void()> task) = 0;

  virtual bool is_current() const = 0;

  virtual std::unique_ptr<TimerBackend> make_timer() = 0;
};

// One-shot or repeating timer. Loop's thread only; destroying it cancels it, and the callback never
// runs after. The callback may destroy the timer.
class Timer {
 public:
  explicit Timer(EventLoop& loop) : backend_(loop.make_timer()) {}
  Timer(const Timer&) = delete;
  Timer& operator=(const Timer&) = delete;

  void start_once(std::chrono::milliseconds delay, std::function<void()> callback) {
    backend_->start(delay, std::chrono::milliseconds(0), std::move(callback));
  }
  void start_repeating(std::chrono::milliseconds interval, std::function<void()> callback) {
    backend_->start(interval, interval, std::move(callback));
  }
  void cancel() { backend_->cancel(); }

 private:
  std::unique_ptr<TimerBackend> backend_;
};

}  // namespace tessera::net
