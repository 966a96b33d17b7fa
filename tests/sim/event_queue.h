// SPDX-License-Identifier: Apache-2.0
// The events of the simulated world and its virtual time. While a queue exists, Clock::now() and
// entropy() of the whole process are its own.
//
// Threads. One thread, and one queue at a time.
// Invariants. (1) Time never goes back. (2) Events of one moment run in the order in which they
// were planned. (3) Equal seeds give equal hashes.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/base/clock.h"
#include "tests/sim/random.h"

namespace tessera::sim {

class EventQueue {
 public:
  using Task = std::function<void()>;

  explicit EventQueue(std::uint64_t seed);
  ~EventQueue();
  EventQueue(const EventQueue&) = delete;
  EventQueue& operator=(const EventQueue&) = delete;

  TimePoint now() const { return now_; }
  double now_seconds() const { return seconds(now_ - start_); }
  void at(TimePoint time, Task task);
  void after(Duration delay, Task task) { at(now_ + delay, std::move(task)); }

  // Runs the next event. Returns: false when there is none.
  bool step();

  std::size_t size() const { return heap_.size(); }
  std::uint64_t event_count() const { return event_count_; }

  // Mixes what happened into the hash of the run.
  void fold(std::uint64_t value) { hash_ = mix(hash_ ^ value) + 0x9e3779b97f4a7c15u; }
  std::uint64_t hash() const { return hash_; }

 private:
  struct Event {
    TimePoint time;
    std::uint64_t order = 0;
    Task task;
  };
  static bool is_later(const Event& a, const Event& b) {
    return a.time != b.time ? a.time > b.time : a.order > b.order;
  }

  const TimePoint start_;
  TimePoint now_;
  std::vector<Event> heap_;
  std::uint64_t next_order_ = 0, event_count_ = 0, hash_ = 0;
  Random entropy_;
};

}  // namespace tessera::sim
