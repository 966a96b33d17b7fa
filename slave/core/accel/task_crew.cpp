// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/task_crew.h"

#include <system_error>

#include "common/base/work_gate.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace tessera::core {
namespace {

// Some 20 microseconds: half of what it costs to sleep and to be woken.
constexpr int kSpins = 500;

thread_local TaskCrew* own_crew = nullptr;

void rest_for_a_moment() {
#if defined(__x86_64__)
  _mm_pause();
#endif
}

// Returns once the value differs.
void wait_for_change(const std::atomic<std::uint32_t>& value, std::uint32_t from) {
  for (int i = 0; i < kSpins; ++i) {
    if (value.load(std::memory_order_acquire) != from) return;
    rest_for_a_moment();
  }
  value.wait(from, std::memory_order_acquire);
}

}  // namespace

TaskCrew::TaskCrew() {
  if (own_crew == nullptr) own_crew = this;
}

TaskCrew::~TaskCrew() {
  if (own_crew == this) own_crew = nullptr;
  for (Member& member : members_) {
    member.work = nullptr;
    member.turn.fetch_add(1, std::memory_order_release);
    member.turn.notify_one();
  }
  for (Member& member : members_) member.thread.join();
}

TaskCrew* TaskCrew::at_rest() {
  return own_crew != nullptr && own_crew->is_at_rest_ ? own_crew : nullptr;
}

void TaskCrew::run(int thread_count, Work work, const void* context) {
  is_at_rest_ = false;
  int called = 0;
  while (called + 1 < thread_count && has_members(called + 1)) {
    Member& member = members_[static_cast<std::size_t>(called++)];
    member.work = work;
    member.context = context;
    member.turn.fetch_add(1, std::memory_order_release);
    member.turn.notify_one();
  }
  work(context, 0);
  {
    const WorkGate::Absence absence;
    for (int i = 0; i < called; ++i) {
      Member& member = members_[static_cast<std::size_t>(i)];
      const std::uint32_t turn = member.turn.load(std::memory_order_acquire);
      if (turn % 2 != 0) wait_for_change(member.turn, turn);
    }
  }
  is_at_rest_ = true;
}

void TaskCrew::serve(Member& member) {
  for (std::uint32_t turn = 0;; turn += 2) {
    wait_for_change(member.turn, turn);
    if (member.work == nullptr) return;
    member.work(member.context, member.number);
    member.turn.fetch_add(1, std::memory_order_release);
    member.turn.notify_one();
  }
}

// Returns: whether the crew has so many members, new ones included.
bool TaskCrew::has_members(int count) {
  if (members_.size() >= static_cast<std::size_t>(count)) return true;
  Member& member = members_.emplace_back();
  member.number = count;
  try {
    member.thread = std::thread([&member] { serve(member); });
  } catch (const std::system_error&) {
    members_.pop_back();
    return false;
  }
  return true;
}

}  // namespace tessera::core
