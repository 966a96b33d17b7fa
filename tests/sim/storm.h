// SPDX-License-Identifier: Apache-2.0
// The storm: one simulated run under the faults of a plan, watched after every event by the
// invariants of the fault matrix.
//
// Threads. One.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/sim/storm_plan.h"

namespace tessera::sim {

struct StormReport {
  std::string violation;  // empty: all held. Starts with the invariant's name
  double at_seconds = 0;  // virtual time of the violation or of the end
  std::uint64_t hash = 0;
  std::uint64_t events = 0;
  std::uint64_t chunks_relayed = 0;  // of scenes, from slave to slave
  std::uint64_t status_answers = 0;
  double frames_seconds = 0;      // from the end of the first frame to that of the last
  std::vector<double> rendering;  // seconds that the threads of each slave had a tile
  int frames_delivered = 0;
  int frames_failed = 0;
};

// has_trace: prints each event that is worth a line.
StormReport run_storm(const StormPlan& plan, bool has_trace = false);

}  // namespace tessera::sim
