// SPDX-License-Identifier: Apache-2.0
// How far a peer's clock is from ours, from pings that say when the peer answered them. Pure.
//
// A sample bounds the offset (theirs minus ours): the answer was written between our sending and
// our receiving, so offset = answered - middle, and the error is at most half the round trip,
// whatever the two ways' shares of it are (Cristian 1989, "Probabilistic clock synchronization").
// The best of a window of samples is taken, as NTP's clock filter does (RFC 5905, section 10); an
// older one is worth less, for quartz clocks drift by up to kDriftMax.
//
// Threads. Plain value, one thread at a time.
//
// Invariants. At most kSamplesMax samples are held.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/base/clock.h"

namespace tessera::master {

struct ClockEstimate {
  std::int64_t offset_ns = 0;  // their clock minus ours
  std::int64_t error_ns = 0;   // bound: the truth is within offset_ns +- error_ns
  bool operator==(const ClockEstimate&) const = default;
};

class ClockOffset {
 public:
  static constexpr std::size_t kSamplesMax = 64;
  static constexpr double kDriftMax = 100e-6;  // between two ordinary quartz clocks, 50 ppm each

  // Adds the sample of one ping: `sent` and `received` by our clock, `answered_ns` by theirs.
  // Samples whose times make no sense (received before sent) are left out.
  void add(TimePoint sent, TimePoint received, std::uint64_t answered_ns);

  // Returns: nothing before the first sample.
  std::optional<ClockEstimate> estimate(TimePoint now) const;

 private:
  struct Sample {
    TimePoint received;
    ClockEstimate estimate;
  };
  std::deque<Sample> samples_;  // oldest first
};

// Returns: the estimate with the smaller error; either may be missing.
std::optional<ClockEstimate> better(const std::optional<ClockEstimate>& a,
                                    const std::optional<ClockEstimate>& b);

}  // namespace tessera::master
