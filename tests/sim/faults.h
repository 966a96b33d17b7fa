// SPDX-License-Identifier: Apache-2.0
// What a plan does to a storm's world: begins its faults, ends them, and tells the oracle whom each
// excuses.
//
// Threads. The simulation's one.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "tests/sim/oracle.h"

namespace tessera::sim {

class Faults {
 public:
  struct World {
    Network& network;
    SimMaster& master;
    SimApp& app;
    std::vector<std::unique_ptr<SimSlave>>& slaves;
    Oracle& oracle;
  };

  // `plan` and what the world refers to outlive the faults.
  Faults(const StormPlan& plan, const World& world) : plan_(plan), world_(world) {}

  void begin(const Fault& fault);
  void end(const Fault& fault);

 private:
  void begin_slave_fault(const Fault& fault);
  void end_slave_fault(const Fault& fault);
  void begin_other_fault(const Fault& fault);
  void begin_relay_fault(const Fault& fault);
  void end_relay_fault(const Fault& fault);
  int peer_of(const Fault& fault);
  void stall_all(int from, int to, bool is_stalled);

  const StormPlan& plan_;
  const World world_;
  std::map<const Fault*, int> peers_;  // whom faults between two slaves have met
};

}  // namespace tessera::sim
