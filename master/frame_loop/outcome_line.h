// SPDX-License-Identifier: Apache-2.0
// Outcomes of frames on their way out, in the order in which the frames ended: one whose digest is
// still being computed holds up those behind it.
//
// Threads. The loop's thread only.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

#include "master/frame_loop/frame_orders.h"

namespace tessera::master {

class OutcomeLine {
 public:
  using Ticket = std::uint64_t;

  // `exit` may call this object back from inside.
  void set_exit(std::function<void(FrameOutcome)> exit) { exit_ = std::move(exit); }

  // Adds an outcome from which nothing is missing.
  void add(FrameOutcome outcome);
  // Adds an outcome that waits for its digest.
  Ticket add_waiting(FrameOutcome outcome);
  // Gives an outcome its digest; does nothing when end() came first.
  void digest_done(Ticket ticket, const Digest& digest);
  // Outcomes that wait leave as failed.
  void end(const Status& reason);

 private:
  struct Entry {
    FrameOutcome outcome;
    bool is_waiting = false;
  };
  void let_go();

  std::function<void(FrameOutcome)> exit_;
  std::deque<Entry> entries_;
  Ticket first_ticket_ = 0;  // of entries_.front()
};

}  // namespace tessera::master
