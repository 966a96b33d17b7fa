// SPDX-License-Identifier: Apache-2.0
// Who ended in a storm, and by whose doing: what may excuse a frame that failed while a healthy
// slave was there, and who may not be there at all.
//
// A frame may fail over a tile that as many different slaves ended with as a tile may end, where
// the last try went to one that was as good as any: a fault of the plan met it, or it had brought
// tiles and ended for the first time. Or where all of them had ended before any good slave had
// rendered anything: nobody can tell a bad slave from a bad tile then.
//
// Threads. The simulation's one.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "common/frame/frame_stats.h"

namespace tessera::sim {

class Endings {
 public:
  void on_master_started();
  void on_counts(const ClusterStatus& status, double now);
  // A fault of the plan meets the slave.
  void on_fault(const std::string& slave) { met_.insert(slave); }
  // A bad slave ends by itself. `has_brought`: tiles, in this life.
  void on_bad_end(const std::string& slave, bool has_brought);

  // Whether `reason`, which names slaves, excuses the failure of a frame.
  bool do_excuse(const std::string& reason) const;
  // Whether the slave was found to lie, and is here before its time is over.
  bool is_back_too_soon(const std::string& slave, double now) const;

 private:
  struct BadEnds {
    int before_any = 0, after = 0;
    bool was_proven = false;  // when it ended for the first time
  };

  std::set<std::string> met_;
  std::map<std::string, BadEnds> bad_;
  std::map<std::string, double> held_until_;  // of those that lied, not of those that were lost
  bool has_rendered_ = false;                 // any good slave, for this master
};

}  // namespace tessera::sim
