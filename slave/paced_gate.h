// SPDX-License-Identifier: Apache-2.0
// The gate of a slave's builder: lets as many threads of a build run as its pace says, and wakes
// those that wait as soon as a render thread has nothing to do.
//
// Threads. Any; no function of it calls anything that locks.
#pragma once

#include <atomic>

#include "common/base/mutex.h"
#include "common/base/work_gate.h"
#include "slave/build_pace.h"

namespace tessera::slave {

class PacedGate final : public WorkGate {
 public:
  // `is_cancelled`: of the build; who waits for the sake of others goes on once it is set and
  // wake() was called. It outlives the gate.
  PacedGate(const BuildPace& pace, const std::atomic<bool>& is_cancelled)
      : is_cancelled_(is_cancelled), pace_(pace) {}

  void set_rendering(int threads);  // render threads that have a tile
  void wake();
  int waiting() const;  // threads of the build

 private:
  void enter() override;
  void leave() override;
  void wait_turn() override;

  const std::atomic<bool>& is_cancelled_;
  mutable Mutex mutex_;
  CondVar has_changed_;
  BuildPace pace_ TESSERA_GUARDED_BY(mutex_);
  int waiting_ TESSERA_GUARDED_BY(mutex_) = 0;
};

}  // namespace tessera::slave
