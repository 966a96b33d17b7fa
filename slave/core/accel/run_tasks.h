// SPDX-License-Identifier: Apache-2.0
// Runs a fixed number of independent tasks on a few threads and waits for all of them.
//
// Threads. The caller works along with up to thread_count - 1 threads of its own making, which are
// joined before the call returns. Tasks are handed out in order, one by one; the outcome must not
// depend on which thread runs a task.
#pragma once

#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace tessera::core {

// Calls task(i) once for each i in [0, task_count).
// Throws: what the first failing task threw, after all threads have stopped; later tasks may be
// left out.
template <typename Task>
void run_tasks(int task_count, int thread_count, const Task& task) {
  std::atomic<int> next{0};
  std::atomic<bool> has_failed{false};
  std::exception_ptr failure;
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
        threads.emplace_back(work);
      } catch (const std::system_error&) {
        break;  // the system has no more threads: those that run do the work
      }
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace tessera::core
