// SPDX-License-Identifier: Apache-2.0
// Shows on stderr that long work goes on, how long it has taken, and how long it may still take: a
// bar on a terminal, plain lines elsewhere, nothing when quiet.
//
// Threads. Progress: any; say() comes from the thread that writes pictures, too. TimeLeft: one.
// Invariants. On a terminal one row is drawn again and again, and never runs over its width. A line
// says the time only once.
#pragma once

#include <cstdio>
#include <optional>
#include <string>

#include "common/base/clock.h"
#include "common/base/mutex.h"

namespace tessera::master {

// The time of one stage of work. The end is guessed from the share that was done since the first
// share was known. A guess that has been shown counts down with the clock, and gives way only to
// one that differs by more than a fifth of what is left, so that the figure can be read and does
// not dance.
class TimeLeft {
 public:
  void begin(TimePoint now);  // a new stage

  // share: done, 0 to 1; negative when unknown. Returns: "12 s spent", or, once some seconds tell
  // enough, "12 s spent, about 25 s left".
  std::string text(double share, TimePoint now);
  std::string spent_text(TimePoint now) const;  // "12 s"

 private:
  void guess(double share, TimePoint now);

  TimePoint began_;
  std::optional<TimePoint> known_since_;  // the first share came
  double first_share_ = 0;
  std::optional<TimePoint> end_;  // as shown
};

class Progress {
 public:
  explicit Progress(bool is_quiet);
  Progress(bool is_quiet, std::FILE* out, bool is_terminal);  // for tests
  ~Progress();                                                // ends the bar's line

  // share in [0, 1], or negative when unknown. Redraws at most every 100 ms; plain lines at most
  // every 2 s and at the end of a stage.
  void update(const std::string& text, double share);
  // Draws a terminal's row again with the present time, for callers whose work tells no new share.
  void tick();
  // The stage is done: a line with `text` and its time is kept, and the next stage begins.
  void finish(const std::string& text);
  // Prints a line of its own above the bar, also when quiet.
  void say(const std::string& line);
  // Takes the bar away, for callers that print to stderr themselves.
  void clear();

 private:
  void draw(TimePoint now) TESSERA_REQUIRES(mutex_);
  void clear_line() TESSERA_REQUIRES(mutex_);

  const bool is_quiet_;
  std::FILE* const out_;
  const bool is_terminal_;

  Mutex mutex_;
  bool has_bar_ TESSERA_GUARDED_BY(mutex_) = false;
  TimeLeft time_ TESSERA_GUARDED_BY(mutex_);
  std::string text_ TESSERA_GUARDED_BY(mutex_);  // as last updated
  double share_ TESSERA_GUARDED_BY(mutex_) = -1;
  std::optional<TimePoint> last_shown_ TESSERA_GUARDED_BY(mutex_);
};

}  // namespace tessera::master
