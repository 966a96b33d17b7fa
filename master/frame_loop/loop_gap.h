// SPDX-License-Identifier: Apache-2.0
// How long the network thread stayed away from its loop: the time by which a task that is due at
// equal intervals comes too late. A heartbeat that is due meanwhile waits as long.
//
// Threads. One owner.
#pragma once

#include <algorithm>
#include <utility>

#include "common/base/clock.h"

namespace tessera::master {

class LoopGap {
 public:
  explicit LoopGap(Duration interval) : interval_(interval) {}

  // To be called by the task. Returns: how late it is; zero for the first call.
  Duration tick(TimePoint now) {
    const bool is_first = !std::exchange(has_ticked_, true);
    const Duration since = now - std::exchange(last_, now);
    return is_first ? Duration::zero() : std::max(since - interval_, Duration::zero());
  }

 private:
  const Duration interval_;
  TimePoint last_{};
  bool has_ticked_ = false;
};

}  // namespace tessera::master
