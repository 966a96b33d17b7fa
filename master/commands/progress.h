// Shows that long work goes on: a bar on a terminal, plain lines elsewhere, nothing when quiet. On
// stderr.
//
// Threads. One at a time.
#pragma once

#include <string>

#include "common/base/clock.h"

namespace tessera::master {

class Progress {
 public:
  explicit Progress(bool is_quiet);
  ~Progress();  // ends the bar's line

  // fraction in [0, 1], or negative when unknown. Redraws at most every 100 ms; plain lines at most
  // every 2 s and at the end of a stage.
  void update(const std::string& text, double fraction);
  // The stage is done: the bar's line is kept with `text`.
  void finish(const std::string& text);

 private:
  void clear_line();

  const bool is_quiet_;
  const bool is_terminal_;
  bool has_bar_ = false;
  TimePoint last_shown_;
};

}  // namespace tessera::master
