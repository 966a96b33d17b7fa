// SPDX-License-Identifier: Apache-2.0
#include "slave/paced_gate.h"

#include "common/base/clock.h"

namespace tessera::slave {

namespace {

// A thread of a build looks at the clock where it could give way, and asks the pace so often.
constexpr Duration kLook = std::chrono::microseconds(100);

}  // namespace

void PacedGate::set_rendering(int threads) {
  MutexLock lock(mutex_);
  pace_.set_rendering(threads, Clock::now());
  is_narrow_.store(pace_.is_narrow(), std::memory_order_relaxed);
  if (waiting_ > 0) has_changed_.notify_all();
}

void PacedGate::wake() {
  MutexLock lock(mutex_);
  has_changed_.notify_all();
}

int PacedGate::waiting() const {
  MutexLock lock(mutex_);
  return waiting_;
}

void PacedGate::enter() {
  MutexLock lock(mutex_);
  pace_.enter(Clock::now());
}

void PacedGate::leave() {
  MutexLock lock(mutex_);
  pace_.leave(Clock::now());
  if (waiting_ > 0) has_changed_.notify_one();
}

void PacedGate::wait_turn() {
  static thread_local TimePoint looked{};
  const TimePoint now = Clock::now();
  if (now - looked < kLook) return;
  {
    MutexLock lock(mutex_);
    if (!pace_.goes_on(now)) {
      ++waiting_;
      has_changed_.notify_one();
      while (!pace_.resumes(Clock::now())) {
        if (is_cancelled_.load(std::memory_order_relaxed)) {
          pace_.enter(Clock::now());
          break;
        }
        has_changed_.wait_until(mutex_, pace_.next_turn(Clock::now()));
      }
      --waiting_;
    }
  }
  looked = Clock::now();
}

}  // namespace tessera::slave
