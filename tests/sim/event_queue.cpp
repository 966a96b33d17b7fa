// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/event_queue.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "common/base/entropy.h"

namespace tessera::sim {
namespace {

EventQueue* current = nullptr;
Random* current_entropy = nullptr;

}  // namespace

// Time begins an hour after the epoch, so that code that subtracts from now() meets no negative
// times.
EventQueue::EventQueue(std::uint64_t seed)
    : start_(TimePoint{} + std::chrono::hours(1)), now_(start_), entropy_(seed ^ 0x656e74726f7079) {
  TESSERA_CHECK(current == nullptr);
  current = this;
  current_entropy = &entropy_;
  Clock::set_source([] { return current->now(); });
  set_entropy_source([] { return current_entropy->next(); });
}

EventQueue::~EventQueue() {
  // Planned events hold objects whose destructors may still ask for the time.
  heap_.clear();
  Clock::set_source(nullptr);
  set_entropy_source(nullptr);
  current = nullptr;
  current_entropy = nullptr;
}

void EventQueue::at(TimePoint time, Task task) {
  heap_.push_back({std::max(time, now_), next_order_++, std::move(task)});
  std::push_heap(heap_.begin(), heap_.end(), is_later);
}

bool EventQueue::step() {
  if (heap_.empty()) return false;
  std::pop_heap(heap_.begin(), heap_.end(), is_later);
  Event event = std::move(heap_.back());
  heap_.pop_back();
  now_ = event.time;
  ++event_count_;
  fold(static_cast<std::uint64_t>(now_.time_since_epoch().count()));
  event.task();
  return true;
}

}  // namespace tessera::sim
