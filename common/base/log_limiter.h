// SPDX-License-Identifier: Apache-2.0
// Decides which lines of a log are written: the first few of each event in an interval. Further
// lines are counted, and summed up in one line later. So a fault that repeats costs a few lines,
// and no line of another event is lost to it.
//
// Threads. Pure, one thread at a time (log.cpp has the lock).
//
// Invariants. (1) At most `lines_max` lines of one event begin in one interval. (2) Every line is
// written or counted in a summary. (3) At most kEventsMax events are told apart; further events
// share one account.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/clock.h"
#include "common/base/event_memory.h"

namespace tessera {

class LogLimiter {
 public:
  static constexpr std::size_t kEventsMax = 256;

  struct Summary {
    std::string event;
    std::uint64_t suppressed = 0;
    double seconds = 0;  // in which the suppressed lines came
  };

  LogLimiter(int lines_max, Duration interval) : lines_max_(lines_max), interval_(interval) {}

  // Whether this line may be written.
  bool admit(std::string_view event, TimePoint now);

  // Takes out what was suppressed in intervals that are over, for the caller to write. `is_last`:
  // takes the present interval, too.
  std::vector<Summary> summaries(TimePoint now, bool is_last = false);

  bool has_suppressed() const { return suppressed_ > 0; }

  // Lines of each event that were ever suppressed, of those that had any, by name.
  std::vector<SuppressedLines> ever_suppressed() const;

 private:
  struct Account {
    TimePoint begin;
    int lines = 0;
    std::uint64_t suppressed = 0;
    std::uint64_t suppressed_before = 0;  // in intervals that are over
  };

  void begin_interval(Account& account, TimePoint now);

  const int lines_max_;
  const Duration interval_;
  std::map<std::string, Account, std::less<>> accounts_;
  std::uint64_t suppressed_ = 0;  // in all accounts
};

}  // namespace tessera
