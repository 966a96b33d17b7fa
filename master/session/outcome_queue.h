// SPDX-License-Identifier: Apache-2.0
// Where finished frames wait for the application, and where submit() waits for room. Shared by both
// kinds of session.
//
// Threads. Any. Invariants. (1) At most frames_in_flight frames are unfinished, and none begins
// while kUndeliveredMax finished ones wait. (2) Frames leave in the order in which they finished,
// which is the order of submission.
#pragma once

#include <chrono>
#include <deque>

#include "common/base/clock.h"
#include "common/base/mutex.h"
#include "common/base/status.h"
#include "master/session/session.h"

namespace tessera::master {

class OutcomeQueue {
 public:
  static constexpr std::size_t kUndeliveredMax = 2;

  explicit OutcomeQueue(int frames_in_flight) : frames_in_flight_(frames_in_flight) {}

  // Waits for room and takes the next frame number. Returns: the reason once ended.
  Result<FrameId> begin_frame() TESSERA_EXCLUDES(mutex_);

  void push(FrameResult result) TESSERA_EXCLUDES(mutex_);

  // Returns: the next frame; else kDeadlineExceeded, or the reason once ended and empty.
  Result<FrameResult> pop(std::chrono::milliseconds timeout) TESSERA_EXCLUDES(mutex_);

  // No new frame comes: waiters get `reason` (not ok). The first reason stays.
  void end(Status reason) TESSERA_EXCLUDES(mutex_);

 private:
  const int frames_in_flight_;  // constant after construction

  Mutex mutex_;
  CondVar changed_;
  std::deque<FrameResult> finished_ TESSERA_GUARDED_BY(mutex_);
  FrameId next_frame_ TESSERA_GUARDED_BY(mutex_) = 0;
  int unfinished_ TESSERA_GUARDED_BY(mutex_) = 0;
  Status ended_ TESSERA_GUARDED_BY(mutex_);
};

}  // namespace tessera::master
