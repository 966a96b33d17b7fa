// SPDX-License-Identifier: Apache-2.0
// The last lines of a log, for who asks a running program and does not see the log itself.
//
// Threads. Pure, one thread at a time (log.cpp has the lock).
//
// Invariant. At most kEventsKept lines of at most kLineBytesMax bytes are kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/clock.h"

namespace tessera {

// A line that was written, for a person. Levels are those of LogLevel, as numbers.
struct PastEvent {
  double seconds_ago = 0;
  std::uint8_t level = 0;
  std::string line;  // "event: text key=value"
  bool operator==(const PastEvent&) const = default;
};

// How many lines of an event were not written since the program began, only summed up.
struct SuppressedLines {
  std::string event;
  std::uint64_t lines = 0;
  bool operator==(const SuppressedLines&) const = default;
};

class EventMemory {
 public:
  static constexpr std::size_t kEventsKept = 100;
  static constexpr std::size_t kLineBytesMax = 480;

  void add(std::uint8_t level, std::string_view line, TimePoint now) {
    if (kept_.size() == kEventsKept) kept_.pop_front();
    kept_.push_back({now, level, std::string(line.substr(0, kLineBytesMax))});
  }

  // The oldest first.
  std::vector<PastEvent> events(TimePoint now) const {
    std::vector<PastEvent> result;
    result.reserve(kept_.size());
    for (const Kept& kept : kept_)
      result.push_back({seconds(now - kept.at), kept.level, kept.line});
    return result;
  }

 private:
  struct Kept {
    TimePoint at;
    std::uint8_t level = 0;
    std::string line;
  };
  std::deque<Kept> kept_;
};

}  // namespace tessera
