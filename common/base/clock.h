// SPDX-License-Identifier: Apache-2.0
// Monotonic time. Pure state machines take `now` as an argument; only the rim reads the clock.
//
// Clock::now() is steady_clock's, unless a simulation has put its own source in: everything above
// common/net asks here, so that a whole cluster can live in virtual time (tests/sim/README.md).
//
// Threads. Any; a source is set while nothing else runs. Nothing here is wall-clock time: it never
// jumps, and means nothing to another machine.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace tessera {

struct Clock {
  using duration = std::chrono::steady_clock::duration;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::steady_clock::time_point;
  static constexpr bool is_steady = true;

  using Source = time_point (*)();

  static time_point now() {
    const Source source = source_.load(std::memory_order_relaxed);
    return source == nullptr ? std::chrono::steady_clock::now() : source();
  }

  // Null: the machine's own clock.
  static void set_source(Source source) { source_.store(source, std::memory_order_relaxed); }

 private:
  static inline std::atomic<Source> source_{nullptr};
};

using TimePoint = Clock::time_point;
using Duration = Clock::duration;

inline double seconds(Duration d) { return std::chrono::duration<double>(d).count(); }

inline Duration from_seconds(double s) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
}

// Reading of this machine's own clock in the form in which messages carry it.
inline std::uint64_t nanoseconds(TimePoint t) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(t.time_since_epoch()).count());
}

}  // namespace tessera
