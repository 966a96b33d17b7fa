// SPDX-License-Identifier: Apache-2.0
// Tells a person that a remote master went away, what is tried meanwhile, and that it is back.
//
// Threads. The one that renders.
#pragma once

#include <string>
#include <utility>

#include "master/commands/progress.h"
#include "master/session/session.h"

namespace tessera::master {

class MasterNews {
 public:
  // What it refers to outlives it. `is_quiet`: nothing is told.
  MasterNews(Session& session, Progress& progress, bool is_quiet)
      : session_(session), progress_(progress), is_quiet_(is_quiet) {}

  // Call now and then while something is waited for. Returns: whether the master is away.
  bool look() {
    const std::string why = session_.interruption();
    const bool was_away = std::exchange(is_away_, !why.empty());
    if (is_away_ && !was_away) say("tessera-master: warning: " + why);
    if (is_away_) progress_.update(why, -1);
    if (!is_away_ && was_away) say("tessera-master: the master is there again: going on");
    return is_away_;
  }

 private:
  void say(const std::string& line) {
    if (!is_quiet_) progress_.say(line);
  }

  Session& session_;
  Progress& progress_;
  const bool is_quiet_;
  bool is_away_ = false;
};

}  // namespace tessera::master
