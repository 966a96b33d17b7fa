// SPDX-License-Identifier: Apache-2.0
// Runs independent tasks on a few threads and waits for all of them: a fixed number, or tasks that
// make further ones.
//
// Threads. The caller works along with up to thread_count - 1 threads of its own making, which are
// joined before the call returns and work behind the caller's gate (work_gate.h). Tasks are handed
// out in order, one by one; the outcome must not depend on which thread runs a task.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "common/base/work_gate.h"

namespace tessera::core {

// Calls task(i) once for each i in [0, task_count).
// Throws: what the first failing task threw, after all threads have stopped; later tasks may be
// left out.
template <typename Task>
void run_tasks(int task_count, int thread_count, const Task& task) {
  std::atomic<int> next{0};
  std::atomic<bool> has_failed{false};
  std::exception_ptr failure;
  WorkGate* const gate = WorkGate::visited();
  const auto work = [&] {
    while (!has_failed.load()) {
      const int i = next.fetch_add(1);
      if (i >= task_count) return;
      try {
        task(i);
      } catch (...) {
        if (!has_failed.exchange(true)) failure = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int t = 1; t < thread_count && t < task_count; ++t) {
      try {
        threads.emplace_back([&] {
          const WorkGate::Visit visit(gate);
          work();
        });
      } catch (const std::system_error&) {
        break;  // the system has no more threads: those that run do the work
      }
    }
    work();
    const WorkGate::Absence absence;
    threads.clear();
  }
  if (failure) std::rethrow_exception(failure);
}

// Calls work(item, put) for the first items and for each item that work puts in by put(item).
// Throws: what the first failing call threw, after all threads have stopped; other items may be
// left out.
template <typename Item, typename Work>
void run_growing(std::deque<Item> waiting, int thread_count, const Work& work) {
  std::mutex mutex;
  std::condition_variable has_changed;
  // Items that wait or are worked on; guarded by the mutex, as are those that wait.
  std::size_t unfinished = waiting.size();
  const auto put = [&](Item item) {
    {
      const std::lock_guard lock(mutex);
      waiting.push_back(item);
      ++unfinished;
    }
    has_changed.notify_one();
  };
  run_tasks(thread_count, thread_count, [&](int) {
    std::unique_lock lock(mutex);
    while (unfinished > 0) {
      if (waiting.empty()) {
        const WorkGate::Absence absence;
        has_changed.wait(lock);
        continue;
      }
      const Item item = waiting.front();
      waiting.pop_front();
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
