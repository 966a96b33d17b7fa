// SPDX-License-Identifier: Apache-2.0
// Where threads that work beside others give way to them. A thread whose work may have to wait, as
// the build of a scene beside rendering, visits a gate, and lets threads that it starts visit it,
// too (run_tasks() does). Work that may take more than a millisecond calls give_way() on its way;
// for a thread that visits no gate, that does nothing.
//
// Threads. Any, each for itself.
#pragma once

#include <atomic>
#include <cstdint>

namespace tessera {

class WorkGate {
 public:
  virtual ~WorkGate() = default;

  // The calling thread works behind the gate; null: behind none. Visits of a thread end in the
  // reverse order of their beginning.
  class Visit {
   public:
    explicit Visit(WorkGate* gate) : before_(visited_) {
      visited_ = gate;
      if (gate != nullptr) gate->enter();
    }
    ~Visit() {
      if (visited_ != nullptr) visited_->leave();
      visited_ = before_;
    }
    Visit(const Visit&) = delete;
    Visit& operator=(const Visit&) = delete;

   private:
    WorkGate* const before_;
  };

  // The calling thread waits for others, and does not count as working.
  class Absence {
   public:
    Absence() {
      if (visited_ != nullptr) visited_->leave();
    }
    ~Absence() {
      if (visited_ != nullptr) visited_->enter();
    }
    Absence(const Absence&) = delete;
    Absence& operator=(const Absence&) = delete;
  };

  static WorkGate* visited() { return visited_; }

 protected:
  std::atomic<bool> is_narrow_{false};  // whether those who pass may have to wait

 private:
  friend void give_way();
  virtual void enter() = 0;
  virtual void leave() = 0;
  virtual void wait_turn() = 0;

  static inline thread_local WorkGate* visited_ = nullptr;
};

// Requires: the thread holds nothing that others wait for.
inline void give_way() {
  WorkGate* const gate = WorkGate::visited_;
  if (gate != nullptr && gate->is_narrow_.load(std::memory_order_relaxed)) gate->wait_turn();
}

// Gives way now and then in a loop of steps that each take some nanoseconds.
class SmallSteps {
 public:
  void next() {
    constexpr std::uint32_t kStepsAtOnce = 4096;
    if (++count_ % kStepsAtOnce == 0) give_way();
  }

 private:
  std::uint32_t count_ = 0;
};

}  // namespace tessera
