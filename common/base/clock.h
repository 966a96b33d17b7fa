// Monotonic time. Pure state machines take `now` as an argument; only the rim reads the clock.
// Threads. Any. Nothing here is wall-clock time: it never jumps, and means nothing to another
// machine.
#pragma once

#include <chrono>

namespace tessera {

using Clock = std::chrono::steady_clock;
using TimePoint = Clock::time_point;
using Duration = Clock::duration;

inline double seconds(Duration d) { return std::chrono::duration<double>(d).count(); }

inline Duration from_seconds(double s) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
}

}  // namespace tessera
