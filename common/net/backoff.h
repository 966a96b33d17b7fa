// SPDX-License-Identifier: Apache-2.0
// How long a slave or an application waits before it tries the master again: pauses double from
// kReconnectFirstMs, each drawn from [0.5, 1.5) of its nominal length so that a room of slaves does
// not knock all at once, and never pass kReconnectMaxMs. Growth starts anew only after a session
// that lasted a minute, so that a flapping link is not hammered (fault-matrix F22).
//
// Threads. Pure: random numbers from a seed and times go in. One owner thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <random>

#include "common/base/clock.h"

namespace tessera::net {

class Backoff {
 public:
  explicit Backoff(std::uint64_t seed);

  // The pause before the next attempt.
  std::chrono::milliseconds next();

  // Tell that a session began, and that it, or an attempt without one, ended.
  void session_began(TimePoint now);
  void session_ended(TimePoint now);

 private:
  std::mt19937_64 random_;
  int doublings_ = 0;
  bool in_session_ = false;
  TimePoint began_{};
};

}  // namespace tessera::net
