// SPDX-License-Identifier: Apache-2.0
#include "master/cluster/clock_offset.h"

#include <cmath>

namespace tessera::master {
namespace {

std::int64_t signed_ns(Duration d) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(d).count();
}

}  // namespace

void ClockOffset::add(TimePoint sent, TimePoint received, std::uint64_t answered_ns) {
  if (received < sent) return;
  const std::int64_t half_trip = signed_ns(received - sent + std::chrono::nanoseconds(1)) / 2;
  const std::int64_t middle = static_cast<std::int64_t>(nanoseconds(sent)) + half_trip;
  // Unsigned, so that a peer's strange clock wraps instead of overflowing.
  const auto offset = static_cast<std::int64_t>(answered_ns - static_cast<std::uint64_t>(middle));
  samples_.push_back({received, {offset, half_trip}});
  if (samples_.size() > kSamplesMax) samples_.pop_front();
}

std::optional<ClockEstimate> ClockOffset::estimate(TimePoint now) const {
  std::optional<ClockEstimate> best;
  for (const Sample& sample : samples_) {
    const double age_ns = std::abs(static_cast<double>(signed_ns(now - sample.received)));
    ClockEstimate aged = sample.estimate;
    aged.error_ns += static_cast<std::int64_t>(kDriftMax * age_ns);
    best = better(best, aged);
  }
  return best;
}

std::optional<ClockEstimate> better(const std::optional<ClockEstimate>& a,
                                    const std::optional<ClockEstimate>& b) {
  if (!a || !b) return a ? a : b;
  return b->error_ns < a->error_ns ? b : a;
}

}  // namespace tessera::master
