// SPDX-License-Identifier: Apache-2.0
// A slave of the simulated world: the product's SlaveNode (with its MasterLink, back-off, liveness
// and scene receiver) in a process, over a workshop in virtual time.
//
// Threads. The simulation's one.
#pragma once

#include <memory>
#include <string>

#include "slave/slave_node.h"
#include "tests/sim/network.h"
#include "tests/sim/sim_workshop.h"

namespace tessera::sim {

class SimSlave {
 public:
  SimSlave(EventQueue& queue, Network& network, std::string name, int node, int master_node,
           WorkModel model);

  void start();
  void kill(bool is_power_lost);
  void leave();  // in order, as on SIGTERM
  void set_hung(bool is_hung);
  void set_frozen(bool is_frozen);  // its render threads, until it is started anew
  // The chunks that it passes on from now on have a wrong bit.
  void set_altering(bool is_altering) { is_altering_ = is_altering; }

  bool is_running() const { return process_ != nullptr; }
  bool is_hung() const { return process_ && process_->is_hung(); }
  bool is_leaving() const { return is_leaving_; }
  const std::string& name() const { return name_; }
  int node() const { return node_; }
  Process* process() const { return process_.get(); }
  const SimWorkshop* workshop() const { return workshop_.get(); }
  WorkModel& model() { return model_; }

 private:
  slave::RelayAccess relay_access();
  void finish_leave(TimePoint deadline);

  EventQueue& queue_;
  Network& network_;
  const std::string name_;
  const int node_, master_node_;
  WorkModel model_;
  std::uint64_t starts_ = 0;
  bool is_leaving_ = false, is_altering_ = false;
  std::unique_ptr<Process> process_;
  std::unique_ptr<SimWorkshop> workshop_;
  std::unique_ptr<slave::SlaveNode> slave_;
};

}  // namespace tessera::sim
