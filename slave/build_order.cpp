// SPDX-License-Identifier: Apache-2.0
#include "slave/build_order.h"

#include <utility>

#include "common/base/check.h"

namespace tessera::slave {

bool BuildOrder::try_push(BuildTask task) {
  if (waiting_.size() >= kWaitingMax) return false;
  if (is_late_ && in_work_ && !is_ahead_ && !is_retired(*in_work_)) gives_way_ = true;
  waiting_.push_back(std::move(task));
  return true;
}

void BuildOrder::retire(std::uint64_t generation, SceneVersion first_kept) {
  const bool was_wanted = in_work_ && !is_retired(*in_work_);
  if (generation != generation_) is_late_ = false;
  generation_ = generation;
  first_kept_ = first_kept;
  if (was_wanted && in_work_->generation == generation && is_retired(*in_work_)) is_late_ = true;
  // They are erased at once, since an animation may retire more than kWaitingMax scenes while one
  // is decoded.
  std::erase_if(waiting_, [this](const BuildTask& task) { return is_retired(task); });
}

const BuildTask& BuildOrder::start_next() {
  TESSERA_CHECK(has_next() && !in_work_);
  is_ahead_ = is_late_ && waiting_.size() > 1;
  const auto next = is_ahead_ ? waiting_.end() - 1 : waiting_.begin();
  in_work_ = std::move(*next);
  waiting_.erase(next);
  return *in_work_;
}

bool BuildOrder::finish(bool was_stopped) {
  BuildTask task = *std::exchange(in_work_, std::nullopt);
  const bool gave_way = std::exchange(gives_way_, false) && was_stopped && !is_retired(task);
  if (gave_way) {
    waiting_.push_front(std::move(task));
  } else if (!was_stopped) {
    is_late_ = false;
  }
  return !gave_way;
}

bool BuildOrder::is_retired(const BuildTask& task) const {
  return task.generation < generation_ ||
         (task.generation == generation_ && task.version < first_kept_);
}

}  // namespace tessera::slave
