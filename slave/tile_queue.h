// SPDX-License-Identifier: Apache-2.0
// The FIFO between the network thread and the render threads, and the account of time that render
// threads lose on it: waiting on an empty queue counts as starved while a frame is open.
//
// Threads. TileQueue: any thread. StarvationClock: pure, guarded by the queue's mutex.
// Invariants. (1) At most `capacity` jobs. (2) First in, first out within a frame; older frames
// first. (3) After close() nothing enters.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include "common/base/clock.h"
#include "common/base/mutex.h"
#include "slave/frame_work.h"

namespace tessera::slave {

// Sum over workers of the time they waited while at least one frame was open.
class StarvationClock {
 public:
  void set_waiting(int workers, TimePoint now) {
    account(now);
    waiting_ = workers;
  }
  void set_open_frames(int frames, TimePoint now) {
    account(now);
    open_frames_ = frames;
  }
  int waiting() const { return waiting_; }

  // Returns: the starved seconds since the last call.
  double take(TimePoint now) {
    account(now);
    const double result = seconds(starved_);
    starved_ = Duration::zero();
    return result;
  }

 private:
  void account(TimePoint now) {
    if (open_frames_ > 0 && now > marked_) starved_ += (now - marked_) * waiting_;
    marked_ = now;
  }

  int waiting_ = 0;
  int open_frames_ = 0;
  Duration starved_{};
  TimePoint marked_{};
};

class TileQueue {
 public:
  using OnWaiting = std::function<void(int workers)>;

  // `on_waiting` is told, under the queue's lock, how many workers wait for a job.
  explicit TileQueue(std::size_t capacity, OnWaiting on_waiting = nullptr)
      : capacity_(capacity), on_waiting_(std::move(on_waiting)) {}

  // Returns: false when full or closed.
  [[nodiscard]] bool try_push(TileJob job) TESSERA_EXCLUDES(mutex_);
  // Sleeps until there is a job. Returns: nothing once closed and empty.
  [[nodiscard]] std::optional<TileJob> pop() TESSERA_EXCLUDES(mutex_);
  // Takes out the jobs of one frame, or all.
  std::deque<TileJob> remove_frame(const FrameWork* frame) TESSERA_EXCLUDES(mutex_);
  std::deque<TileJob> remove_all() TESSERA_EXCLUDES(mutex_);

  void set_open_frames(std::size_t frames) TESSERA_EXCLUDES(mutex_);
  double take_starved_seconds() TESSERA_EXCLUDES(mutex_);
  void close() TESSERA_EXCLUDES(mutex_);

 private:
  void set_waiting(int workers) TESSERA_REQUIRES(mutex_);

  const std::size_t capacity_;
  const OnWaiting on_waiting_;  // may be null

  mutable Mutex mutex_;
  CondVar not_empty_;
  std::deque<TileJob> jobs_ TESSERA_GUARDED_BY(mutex_);
  StarvationClock starvation_ TESSERA_GUARDED_BY(mutex_);
  bool is_closed_ TESSERA_GUARDED_BY(mutex_) = false;
};

}  // namespace tessera::slave
