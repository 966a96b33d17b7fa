// SPDX-License-Identifier: Apache-2.0
// Threads that stay for a whole build. A build has some hundred short stretches that several
// threads share; threads made anew for each cost more than many of them (30 to 50 microseconds
// apiece), and give the memory of their heaps back in between.
//
// Who waits looks some hundred times before it sleeps: the next stretch is mostly near, and waking
// a thread costs as much as making one.
//
// Threads. A crew belongs to the thread that makes it. run_tasks() finds it there, and its members
// work as the caller's own threads would; they are joined before the crew's end. They share no
// lock.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <thread>

namespace tessera::core {

class TaskCrew {
 public:
  // What a stretch calls, once on each of its threads: work(context, thread). Throws nothing.
  using Work = void (*)(const void* context, int thread);

  // Members come when they are first needed. Where the calling thread has a crew already, that one
  // does this one's work.
  TaskCrew();
  ~TaskCrew();
  TaskCrew(const TaskCrew&) = delete;
  TaskCrew& operator=(const TaskCrew&) = delete;

  // Returns: the calling thread's crew if it is at rest; null otherwise.
  static TaskCrew* at_rest();

  // Calls work(context, t) for t in [0, thread_count), the 0th on the calling thread, and returns
  // when all have returned. Where the system has no more threads, those that there are work.
  void run(int thread_count, Work work, const void* context);

 private:
  struct alignas(128) Member {
    // Grows by one when there is work, and by one when that is done.
    std::atomic<std::uint32_t> turn{0};
    Work work = nullptr;  // null: the end
    const void* context = nullptr;
    int number = 0;
    std::thread thread{};
  };

  static void serve(Member& member);
  bool has_members(int count);

  bool is_at_rest_ = true;
  std::deque<Member> members_;
};

}  // namespace tessera::core
