// SPDX-License-Identifier: Apache-2.0
// The master of the simulated world: the product's FrameLoop (with its Cluster, Reception,
// PeerLinks, SceneSenders, AppServer, Scheduler and ledgers) in a process that listens.
//
// Threads. The simulation's one.
#pragma once

#include <memory>

#include "master/frame_loop/frame_loop.h"
#include "tests/sim/door.h"
#include "tests/sim/network.h"

namespace tessera::sim {

class SimMaster {
 public:
  SimMaster(EventQueue& queue, Network& network, int node, const master::FrameLoopOptions& options,
            Duration record_cost);
  ~SimMaster();

  void start();
  void kill(bool is_power_lost);
  void set_hung(bool is_hung);
  bool is_running() const { return process_ != nullptr; }
  bool is_hung() const { return process_ && process_->is_hung(); }
  int node() const { return node_; }
  Process* process() const { return process_.get(); }
  master::FrameLoop& loop() { return *loop_; }

 private:
  EventQueue& queue_;
  Network& network_;
  const int node_;
  const master::FrameLoopOptions options_;
  const Duration record_cost_;
  std::unique_ptr<Process> process_;
  std::unique_ptr<Door> door_;
  std::unique_ptr<master::FrameLoop> loop_;
};

}  // namespace tessera::sim
