// SPDX-License-Identifier: Apache-2.0
#include "master/session/outcome_queue.h"

#include <utility>

namespace tessera::master {

Result<FrameId> OutcomeQueue::begin_frame() {
  MutexLock lock(mutex_);
  while (ended_.is_ok() &&
         (unfinished_ >= frames_in_flight_ || finished_.size() >= kUndeliveredMax)) {
    changed_.wait(mutex_);
  }
  if (!ended_.is_ok()) return ended_;
  ++unfinished_;
  return next_frame_++;
}

void OutcomeQueue::push(FrameResult result) {
  {
    MutexLock lock(mutex_);
    --unfinished_;
    finished_.push_back(std::move(result));
  }
  changed_.notify_all();
}

Result<FrameResult> OutcomeQueue::pop(std::chrono::milliseconds timeout) {
  const TimePoint deadline = Clock::now() + timeout;
  MutexLock lock(mutex_);
  while (finished_.empty()) {
    if (!ended_.is_ok()) return ended_;
    if (!changed_.wait_until(mutex_, deadline) && finished_.empty()) {
      if (!ended_.is_ok()) return ended_;
      return Status::deadline_exceeded("no frame finished in time");
    }
  }
  FrameResult result = std::move(finished_.front());
  finished_.pop_front();
  changed_.notify_all();
  return result;
}

void OutcomeQueue::end(Status reason) {
  {
    MutexLock lock(mutex_);
    if (ended_.is_ok()) ended_ = std::move(reason);
  }
  changed_.notify_all();
}

}  // namespace tessera::master
