// SPDX-License-Identifier: Apache-2.0
// How many threads of a build may run beside the render threads of a slave: as many as render
// threads have no tile, and a small part of all processors beyond that, so that a build goes on
// while every thread renders. That part is reckoned in processor time: threads of the build that
// run beyond what is free spend it, and it comes back as time passes.
//
// Threads. One owner, or a lock around it. Pure: the caller brings the time, which never goes back.
#pragma once

#include "common/base/clock.h"

namespace tessera::slave {

class BuildPace {
 public:
  // What a build may take from rendering. A tenth is what rendering may lose, and of that some goes
  // to caches that both fill.
  static constexpr double kShare = 1.0 / 16;
  // A thread that waited runs for so long before it waits again.
  static constexpr Duration kTurn = std::chrono::milliseconds(1);

  // `processors`: those of the slave, as many as it has render threads. `share`: of their time.
  explicit BuildPace(int processors, double share = kShare);

  void set_rendering(int threads, TimePoint now);  // render threads that have a tile
  void enter(TimePoint now);                       // a thread of the build begins, and runs
  void leave(TimePoint now);                       // a running thread ends

  // A running thread asks whether it may go on. Returns: false when it is to wait.
  [[nodiscard]] bool goes_on(TimePoint now);
  // A waiting thread asks. Returns: whether it runs again.
  [[nodiscard]] bool resumes(TimePoint now);
  // When a waiting thread is to ask again, unless something else changes before. Never in the past.
  TimePoint next_turn(TimePoint now) const;

  int running() const { return running_; }
  bool is_narrow() const { return rendering_ > 0; }

 private:
  void account(TimePoint now);
  int free() const { return processors_ - rendering_; }
  // Threads beyond the free processors that may run at a time.
  int beyond_max() const { return 1 + static_cast<int>(refill()); }
  double refill() const { return share_ * processors_; }  // processors' time in each second

  const int processors_;
  const double share_;
  int rendering_ = 0;
  int running_ = 0;
  double credit_seconds_ = 0;  // at most one turn of each that may run beyond; below 0: owed
  TimePoint marked_{};
};

}  // namespace tessera::slave
