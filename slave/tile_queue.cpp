// SPDX-License-Identifier: Apache-2.0
#include "slave/tile_queue.h"

#include <iterator>
#include <utility>

namespace tessera::slave {

bool TileQueue::try_push(TileJob job) {
  {
    MutexLock lock(mutex_);
    if (is_closed_ || jobs_.size() >= capacity_) return false;
    // The place is almost always the end. A tile of an older frame that comes late (its first slave
    // was lost, or is slow) is what somebody waits for.
    auto place = jobs_.end();
    while (place != jobs_.begin() && job.frame->begin.frame < std::prev(place)->frame->begin.frame)
      --place;
    jobs_.insert(place, std::move(job));
  }
  not_empty_.notify_one();
  return true;
}

std::optional<TileJob> TileQueue::pop() {
  MutexLock lock(mutex_);
  if (jobs_.empty() && !is_closed_) {
    set_waiting(starvation_.waiting() + 1);
    while (jobs_.empty() && !is_closed_) not_empty_.wait(mutex_);
    set_waiting(starvation_.waiting() - 1);
  }
  if (jobs_.empty()) return std::nullopt;
  TileJob job = std::move(jobs_.front());
  jobs_.pop_front();
  return job;
}

void TileQueue::set_waiting(int workers) {
  starvation_.set_waiting(workers, Clock::now());
  if (on_waiting_) on_waiting_(workers);
}

std::deque<TileJob> TileQueue::remove_frame(const FrameWork* frame) {
  MutexLock lock(mutex_);
  std::deque<TileJob> kept;
  std::deque<TileJob> removed;
  for (TileJob& job : jobs_) (job.frame.get() == frame ? removed : kept).push_back(std::move(job));
  jobs_ = std::move(kept);
  return removed;
}

std::deque<TileJob> TileQueue::remove_all() {
  MutexLock lock(mutex_);
  return std::exchange(jobs_, {});
}

void TileQueue::set_open_frames(std::size_t frames) {
  MutexLock lock(mutex_);
  starvation_.set_open_frames(static_cast<int>(frames), Clock::now());
}

double TileQueue::take_starved_seconds() {
  MutexLock lock(mutex_);
  return starvation_.take(Clock::now());
}

void TileQueue::close() {
  {
    MutexLock lock(mutex_);
    is_closed_ = true;
  }
  not_empty_.notify_all();
}

}  // namespace tessera::slave
