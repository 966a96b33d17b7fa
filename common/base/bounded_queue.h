// SPDX-License-Identifier: Apache-2.0
// A FIFO queue with a fixed capacity between threads. Any thread may call any function.
//
// Invariants. (1) size() <= capacity. (2) Elements leave in the order in which they came.
// (3) After close() nothing enters, and pop() returns nothing once the queue is empty.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

#include "common/base/check.h"
#include "common/base/mutex.h"

namespace tessera {

template <typename T>
class BoundedQueue {
 public:
  // Requires: capacity >= 1.
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {
    TESSERA_CHECK_GE(capacity, 1u);
  }

  // Returns: false when full or closed; the element is then not queued.
  [[nodiscard]] bool try_push(T element) TESSERA_EXCLUDES(mutex_) {
    {
      MutexLock lock(mutex_);
      if (closed_ || elements_.size() >= capacity_) return false;
      elements_.push_back(std::move(element));
    }
    not_empty_.notify_one();
    return true;
  }

  // Sleeps until there is an element. Returns: nothing once the queue is closed and empty.
  [[nodiscard]] std::optional<T> pop() TESSERA_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    while (elements_.empty() && !closed_) not_empty_.wait(mutex_);
    return take_front();
  }

  [[nodiscard]] std::optional<T> try_pop() TESSERA_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return take_front();
  }

  // Removes every element for which `drop` holds. Returns: the removed ones, in order.
  template <typename Predicate>
  std::deque<T> remove_if(Predicate drop) TESSERA_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    std::deque<T> kept;
    std::deque<T> removed;
    for (T& element : elements_) (drop(element) ? removed : kept).push_back(std::move(element));
    elements_ = std::move(kept);
    return removed;
  }

  std::size_t size() const TESSERA_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return elements_.size();
  }

  // Lets waiting threads end. Safe to call twice.
  void close() TESSERA_EXCLUDES(mutex_) {
    {
      MutexLock lock(mutex_);
      closed_ = true;
    }
    not_empty_.notify_all();
  }

 private:
  std::optional<T> take_front() TESSERA_REQUIRES(mutex_) {
    if (elements_.empty()) return std::nullopt;
    T element = std::move(elements_.front());
    elements_.pop_front();
    return element;
  }

  const std::size_t capacity_;  // constant after construction

  mutable Mutex mutex_;
  CondVar not_empty_;
  std::deque<T> elements_ TESSERA_GUARDED_BY(mutex_);
  bool closed_ TESSERA_GUARDED_BY(mutex_) = false;
};

}  // namespace tessera
