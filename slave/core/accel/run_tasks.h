// SPDX-License-Identifier: Apache-2.0
// Runs independent tasks on a few threads and waits for all of them: a fixed number, or tasks that
// make further ones.
//
// Threads. The caller works along with up to thread_count - 1 threads of its crew (task_crew.h), or
// of one made for this call; they work behind the caller's gate (work_gate.h). Each takes a run of
// neighbouring tasks first, one by one, and then what others have left: neighbours mostly touch the
// same memory, which so keeps to the caches of one core. The outcome must not depend on which
// thread runs a task.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <iterator>
#include <mutex>
#include <utility>
#include <vector>

#include "common/base/work_gate.h"
#include "slave/core/accel/task_crew.h"

namespace tessera::core {

// Calls task(i) once for each i in [0, task_count).
// Throws: what the first failing task threw, after all threads have stopped; later tasks may be
// left out.
template <typename Task>
void run_tasks(int task_count, int thread_count, const Task& task) {
  struct alignas(128) Share {
    std::atomic<int> next{0};
    int end = 0;
  };
  const int share_count = std::max(1, std::min(thread_count, task_count));
  std::vector<Share> shares(static_cast<std::size_t>(share_count));
  for (int s = 0; s < share_count; ++s) {
    Share& share = shares[static_cast<std::size_t>(s)];
    share.next = static_cast<int>(std::int64_t{task_count} * s / share_count);
    share.end = static_cast<int>(std::int64_t{task_count} * (s + 1) / share_count);
  }
  std::atomic<bool> has_failed{false};
  std::exception_ptr failure;
  WorkGate* const gate = WorkGate::visited();
  const auto work = [&](int own) {
    for (int s = 0; s < share_count; ++s) {
      Share& share = shares[static_cast<std::size_t>((own + s) % share_count)];
      while (!has_failed.load()) {
        const int i = share.next.fetch_add(1);
        if (i >= share.end) break;
        try {
          task(i);
        } catch (...) {
          if (!has_failed.exchange(true)) failure = std::current_exception();
        }
      }
    }
  };
  const auto behind_gate = [&](int thread) {
    if (thread == 0) return work(0);
    const WorkGate::Visit visit(gate);
    work(thread);
  };
  using OnThread = decltype(behind_gate);
  const auto call = [](const void* on_thread, int thread) {
    (*static_cast<const OnThread*>(on_thread))(thread);
  };
  TaskCrew* const crew = TaskCrew::at_rest();
  if (crew != nullptr) {
    crew->run(share_count, call, &behind_gate);
  } else {
    TaskCrew().run(share_count, call, &behind_gate);
  }
  if (failure) std::rethrow_exception(failure);
}

// Items that wait for a thread. A thread takes the newest that it put in itself, whose memory is in
// its core's caches. Where it has none, it takes another's oldest, which is mostly the largest.
template <typename Item>
class WaitingItems {
 public:
  bool is_empty() const { return entries_.empty(); }
  std::size_t size() const { return entries_.size(); }
  void put(Item item, int thread) { entries_.push_back({std::move(item), thread}); }
  // Requires: !is_empty().
  Item take(int thread) {
    const auto own = std::find_if(entries_.rbegin(), entries_.rend(),
                                  [thread](const Entry& entry) { return entry.maker == thread; });
    const auto from = own == entries_.rend() ? entries_.begin() : std::prev(own.base());
    Item item = std::move(from->item);
    entries_.erase(from);
    return item;
  }

 private:
  struct Entry {
    Item item;
    int maker;
  };
  std::deque<Entry> entries_;
};

// Calls work(item, put) for the first items and for each item that work puts in by put(item).
// Throws: what the first failing call threw, after all threads have stopped; other items may be
// left out.
template <typename Item, typename Work>
void run_growing(const std::deque<Item>& first, int thread_count, const Work& work) {
  std::mutex mutex;
  std::condition_variable has_changed;
  WaitingItems<Item> waiting;  // guarded by the mutex
  for (std::size_t i = 0; i < first.size(); ++i) {
    waiting.put(first[i],
                static_cast<int>(i * static_cast<std::size_t>(thread_count) / first.size()));
  }
  std::size_t unfinished = waiting.size();  // wait or are worked on; guarded by the mutex
  run_tasks(thread_count, thread_count, [&](int thread) {
    const auto put = [&](Item item) {
      {
        const std::lock_guard lock(mutex);
        waiting.put(std::move(item), thread);
        ++unfinished;
      }
      has_changed.notify_one();
    };
    std::unique_lock lock(mutex);
    while (unfinished > 0) {
      if (waiting.is_empty()) {
        const WorkGate::Absence absence;
        has_changed.wait(lock);
        continue;
      }
      const Item item = waiting.take(thread);
      lock.unlock();
      std::exception_ptr failure;
      try {
        work(item, put);
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      unfinished = failure || unfinished == 0 ? 0 : unfinished - 1;
      if (unfinished == 0) has_changed.notify_all();
      if (failure) std::rethrow_exception(failure);
    }
  });
}

}  // namespace tessera::core
