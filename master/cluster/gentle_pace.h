// SPDX-License-Identifier: Apache-2.0
// How fast scene data may go to a slave that joins while the others are rendering: one window at a
// time, and after each a rest as long as the window took. So at most one window stands in the queue
// of the master's link, in front of leases and frames, and at most half of the link is used,
// whatever it carries; and the joiner always goes on.
//
// The idea is that of LEDBAT (RFC 6817): background data yields to what shares its queue. This is
// simpler, since a window is small against what others send.
//
// Threads. One owner. Pure.
#pragma once

#include "common/base/clock.h"
#include "common/net/link_counters.h"

namespace tessera::master {

class GentlePace {
 public:
  // A window that never seems to arrive (counters that do not count) is taken for lost.
  static constexpr std::chrono::milliseconds kWindowTimeMax{1000};

  bool may_send(TimePoint now, const net::LinkCounters& counters) {
    if (is_on_the_way_) {
      const bool has_arrived = counters.queue_bytes == 0 && counters.on_the_way_bytes == 0;
      if (!has_arrived && now - sent_ < kWindowTimeMax) return false;
      is_on_the_way_ = false;
      rest_until_ = now + (now - sent_);
    }
    return now >= rest_until_;
  }

  // Call when a window is about to be queued.
  void sent(TimePoint now) {
    is_on_the_way_ = true;
    sent_ = now;
  }

 private:
  bool is_on_the_way_ = false;
  TimePoint sent_{}, rest_until_{};
};

}  // namespace tessera::master
