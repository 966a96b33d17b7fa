// SPDX-License-Identifier: Apache-2.0
// What the rays of a thread have met that is built when a ray meets it: whether another thread was
// at it, so that the tile is better left for a later one, and whether it could be built at all.
//
// Threads. One, which is the one that traces, from the constructor to the destructor.
#pragma once

#include <utility>

#include "common/base/status.h"

namespace tessera::core {

class MetBuilds {
 public:
  // What a thread does that meets what another one builds; a thread without a MetBuilds waits.
  enum class WhenBusy { kLeaveTile, kWait };

  explicit MetBuilds(WhenBusy when_busy)
      : when_busy_(when_busy), outer_(std::exchange(of_thread(), this)) {}
  // What failed within a part of the work has failed for the whole.
  ~MetBuilds() {
    of_thread() = outer_;
    if (outer_ != nullptr) outer_->fail(failure_);
  }
  MetBuilds(const MetBuilds&) = delete;
  MetBuilds& operator=(const MetBuilds&) = delete;

  // Whether a ray met what another thread builds: the answers since then are worth nothing.
  bool has_left() const { return has_left_; }
  // Not ok where a ray met what could not be built: likewise.
  const Status& failure() const { return failure_; }
  // Whether the calling thread's answers are worth nothing.
  static bool is_to_leave() {
    const MetBuilds* const here = of_thread();
    return here != nullptr && (here->has_left_ || !here->failure_.is_ok());
  }

  // For what builds. Returns: the calling thread's innermost one; may be null.
  static MetBuilds*& of_thread() {
    static thread_local MetBuilds* innermost = nullptr;
    return innermost;
  }
  bool may_leave() const { return when_busy_ == WhenBusy::kLeaveTile; }
  void leave() { has_left_ = true; }
  void fail(const Status& failure) {
    if (failure_.is_ok()) failure_ = failure;
  }

 private:
  const WhenBusy when_busy_;
  bool has_left_ = false;
  Status failure_;
  MetBuilds* const outer_;
};

}  // namespace tessera::core
