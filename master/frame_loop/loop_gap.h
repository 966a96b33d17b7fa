// SPDX-License-Identifier: Apache-2.0
// How long the network thread stayed away from its loop: the time by which a task that is due at
// equal intervals comes too late. A heartbeat that is due meanwhile waits as long.
//
// Threads. One owner.
#pragma once

#include <algorithm>
#include <optional>

#include "common/base/clock.h"

namespace tessera::master {

class LoopGap {
 public:
  explicit LoopGap(Duration interval) : interval_(interval) {}

  // To be called by the task. Returns: how late it is; zero for the first call.
  Duration tick(TimePoint now) {
    const Duration late = last_ ? std::max(now - *last_ - interval_, Duration::zero()) : Duration{};
    last_ = now;
    return late;
  }

 private:
  const Duration interval_;
  std::optional<TimePoint> last_;
};

}  // namespace tessera::master
