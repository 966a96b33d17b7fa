// SPDX-License-Identifier: Apache-2.0
// The state of another thread, as the kernel tells it. With it a test knows that the thread waits,
// or how much it has computed, instead of pausing for a while.
//
// Threads. Any.
#pragma once

#include <pthread.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <string>
#include <thread>

namespace tessera::test {

// A thread that runs `work`, of which a test can ask whether it sleeps.
class WatchedThread {
 public:
  template <class Work>
  explicit WatchedThread(Work work)
      : thread_([this, work = std::move(work)] {
          id_ = gettid();
          work();
        }) {}
  ~WatchedThread() { join(); }
  WatchedThread(const WatchedThread&) = delete;
  WatchedThread& operator=(const WatchedThread&) = delete;

  void join() {
    if (thread_.joinable()) thread_.join();
  }
  // Returns when the thread waits for something, or has ended.
  void wait_until_asleep() const {
    while (id_ == 0) std::this_thread::yield();
    const std::string file = "/proc/self/task/" + std::to_string(id_) + "/stat";
    for (;;) {
      std::ifstream stat(file);
      std::string text;
      if (!std::getline(stat, text)) return;
      const auto end_of_name = text.rfind(')');
      if (end_of_name != text.npos && text.compare(end_of_name, 3, ") S") == 0) return;
      std::this_thread::yield();
    }
  }

 private:
  std::atomic<pid_t> id_{0};
  std::thread thread_;  // last: it uses the others
};

// CPU-seconds that a thread has used so far, which pass for it alone.
class ProcessorClock {
 public:
  explicit ProcessorClock(pthread_t thread) { pthread_getcpuclockid(thread, &clock_); }
  double seconds() const {
    timespec now{};
    clock_gettime(clock_, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

 private:
  clockid_t clock_{};
};

}  // namespace tessera::test
