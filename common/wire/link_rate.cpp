// SPDX-License-Identifier: Apache-2.0
#include "common/wire/link_rate.h"

namespace tessera::wire {
namespace {

double seconds_of(std::chrono::microseconds time) {
  return 1e-6 * static_cast<double>(time.count());
}

bool has_queue(const net::LinkCounters& before, const net::LinkCounters& now) {
  if (before.queue_bytes > 0 && now.queue_bytes > 0) return true;
  return before.on_the_way_bytes >= LinkRate::kOnTheWayMin &&
         now.on_the_way_bytes >= LinkRate::kOnTheWayMin && now.rtt >= 2 * now.rtt_min &&
         now.rtt - now.rtt_min >= LinkRate::kQueueingMin;
}

// An acknowledgement of the last bytes may be put off by so much.
constexpr std::chrono::microseconds kPutOff{40'000};

// The time that the link took for what waited when it was looked at last, where that is long enough
// to tell: all of it may have been carried since. Zero where most of what moved came later.
std::chrono::microseconds time_for_what_waited(const net::LinkCounters& before,
                                               const net::LinkCounters& now) {
  const std::uint64_t moved = now.bytes_moved - before.bytes_moved;
  if (moved > 2 * (before.queue_bytes + before.on_the_way_bytes)) return {};
  const auto time = now.busy - before.busy - kPutOff;
  return time >= LinkRate::kBusyMin ? time : std::chrono::microseconds{};
}

}  // namespace

void LinkRate::observe(const net::LinkCounters& counters) {
  const net::LinkCounters before = last_.value_or(counters);
  last_ = counters;
  const double moved = static_cast<double>(counters.bytes_moved - before.bytes_moved);
  const double busy = seconds_of(counters.busy - before.busy);
  if (!(busy > 0)) return;
  const double memory = seconds_of(kMemory);
  const double for_waiting = seconds_of(time_for_what_waited(before, counters));
  const bool is_queueing = has_queue(before, counters);
  if (is_queueing || for_waiting > 0) {
    bytes_ += moved;
    busy_seconds_ += is_queueing ? busy : for_waiting;
    free_bytes_ = free_seconds_ = 0;
    if (busy_seconds_ > memory) {
      bytes_ *= memory / busy_seconds_;
      busy_seconds_ = memory;
    }
    return;
  }
  // Without a queue the link shows only how fast it is at least. The measured rate stands until
  // that is clearly more: a coding that made the queue vanish must not be given up because it
  // vanished.
  free_bytes_ += moved;
  free_seconds_ += busy;
  if (free_seconds_ < seconds_of(kBusyMin)) return;
  if (free_bytes_ * busy_seconds_ > 2 * bytes_ * free_seconds_) bytes_ = busy_seconds_ = 0;
  free_bytes_ = free_seconds_ = 0;
}

std::optional<double> LinkRate::bytes_per_second() const {
  if (busy_seconds_ < seconds_of(kBusyMin) || !(bytes_ > 0)) return std::nullopt;
  return bytes_ / busy_seconds_;
}

}  // namespace tessera::wire
