// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/outcome_line.h"

#include <utility>

namespace tessera::master {

void OutcomeLine::add(FrameOutcome outcome) {
  entries_.push_back({std::move(outcome), false});
  let_go();
}

OutcomeLine::Ticket OutcomeLine::add_waiting(FrameOutcome outcome) {
  entries_.push_back({std::move(outcome), true});
  return first_ticket_ + entries_.size() - 1;
}

void OutcomeLine::digest_done(Ticket ticket, const Digest& digest) {
  if (ticket < first_ticket_) return;
  Entry& entry = entries_[ticket - first_ticket_];
  entry.outcome.stats.digest = digest;
  entry.is_waiting = false;
  let_go();
}

void OutcomeLine::end(const Status& reason) {
  for (Entry& entry : entries_) {
    if (!std::exchange(entry.is_waiting, false)) continue;
    entry.outcome.status = reason;
    entry.outcome.image.reset();
  }
  let_go();
}

void OutcomeLine::let_go() {
  while (!entries_.empty() && !entries_.front().is_waiting) {
    FrameOutcome outcome = std::move(entries_.front().outcome);
    entries_.pop_front();
    ++first_ticket_;
    if (exit_) exit_(std::move(outcome));
  }
}

}  // namespace tessera::master
