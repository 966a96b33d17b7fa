// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/frame_admission.h"

#include <algorithm>

namespace tessera::master {

void FrameAdmission::add(FrameId frame, std::uint64_t needed_bytes, TimePoint now) {
  if (line_.empty()) first_since_ = now;
  line_.push_back({frame, needed_bytes});
}

bool FrameAdmission::cancel(FrameId frame) {
  const auto waiting = std::find_if(line_.begin(), line_.end(),
                                    [frame](const Waiting& w) { return w.frame == frame; });
  if (waiting == line_.end()) return false;
  waiting->is_cancelled = true;
  return true;
}

std::optional<std::uint64_t> FrameAdmission::free_bytes(const FrameHoldings& holdings) const {
  const std::optional<std::uint64_t> room = room_ ? room_() : std::nullopt;
  if (!room) return std::nullopt;
  return *room - std::min(*room, kReserveBytes + holdings.promised);
}

std::optional<FrameAdmission::Decision> FrameAdmission::next(const FrameHoldings& holdings,
                                                             TimePoint now) {
  if (line_.empty()) return std::nullopt;
  const Waiting first = line_.front();
  Decision decision{first.frame, Verdict::kTaken, first.needed_bytes, 0};
  if (first.is_cancelled) {
    decision.verdict = Verdict::kCancelled;
  } else if (const auto free = free_bytes(holdings); free && first.needed_bytes > *free) {
    const bool is_enough_later = first.needed_bytes <= *free + holdings.promised + holdings.written;
    if (is_enough_later) {
      hopeless_since_.reset();
    } else if (!hopeless_since_) {
      hopeless_since_ = now;
    }
    const bool is_hopeless = hopeless_since_ && now - *hopeless_since_ >= kHopelessFor;
    if (!is_hopeless && now - first_since_ < kWaitMax) return std::nullopt;
    decision.verdict = Verdict::kRefused;
    decision.free_bytes = *free;
  }
  line_.pop_front();
  first_since_ = now;
  hopeless_since_.reset();
  return decision;
}

}  // namespace tessera::master
