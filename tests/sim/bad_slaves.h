// SPDX-License-Identifier: Apache-2.0
// Slaves of a storm that do what no slave should, beside those of the plan: they die with a tile
// and are started again at once, hold tiles and return none, lie about them and come back as new
// processes, take others' names, and forge pixels. They are the product's own, over a workshop that
// does it. What they do is no excuse for anybody, but for whose name is taken.
//
// Threads. The simulation's one.
#pragma once

#include <memory>
#include <vector>

#include "tests/sim/oracle.h"

namespace tessera::sim {

class BadSlaves {
 public:
  // `plan` outlives them. `network` gets a machine for each.
  BadSlaves(EventQueue& queue, Network& network, int master_node, const StormPlan& plan);
  ~BadSlaves();

  // Starts each at its time. `until_seconds`: when end() will be called.
  void start(Oracle& oracle, double until_seconds);
  // Ends all of them for good.
  void end();

 private:
  struct One {
    const BadSlavePlan& plan;
    std::unique_ptr<SimSlave> slave;
    bool is_dying = false;
    int begun = 0, brought = 0;  // tiles, in this life
  };

  WorkModel model_of(std::size_t index);
  void begin_life(std::size_t index);
  void on_begin(std::size_t index, TileIndex tile);
  void die(std::size_t index);
  void start_anew(std::size_t index);
  void go_and_return(std::size_t index);

  EventQueue& queue_;
  const StormPlan& plan_;
  Oracle* oracle_ = nullptr;  // from start() on
  std::vector<One> all_;
  bool is_over_ = false;
};

}  // namespace tessera::sim
