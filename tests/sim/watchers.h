// SPDX-License-Identifier: Apache-2.0
// Status clients of a storm: they connect, ask some times, and leave in every way that there is:
// with a goodbye, with two of them, with a message that is not theirs to send (twice), by a reset
// while answers are on their way, or with their machine. They speak the protocol by themselves,
// record by record, as no client of the product would. Whatever they do, it costs nobody anything
// and the master keeps nothing of them.
//
// Threads. The simulation's one.
#pragma once

#include <memory>
#include <vector>

#include "common/net/connector.h"
#include "tests/sim/network.h"
#include "tests/sim/random.h"

namespace tessera::sim {

class Watchers {
 public:
  // `count` of them, each on a machine of its own.
  Watchers(EventQueue& queue, Network& network, int master_node, int count, std::uint64_t seed);
  ~Watchers();

  void start();
  // Ends all of them for good.
  void end();
  // Answers to their questions so far.
  std::uint64_t answers() const { return answers_; }

 private:
  enum class Leaving { kGoodbye, kTwoGoodbyes, kBreach, kReset, kPowerLoss, kCount };
  struct One {
    int node = 0;
    std::unique_ptr<Process> process;
    std::unique_ptr<net::ConnectAttempt> attempt;
    net::ConnectionPtr link;
    int questions = 0;  // still to be asked
  };

  void come(std::size_t index);
  void on_connected(std::size_t index, Result<net::ConnectionPtr> link);
  void on_record(std::size_t index, net::ReceivedRecord record);
  void ask(std::size_t index);
  void leave(std::size_t index);
  void go(std::size_t index, bool is_power_lost);

  EventQueue& queue_;
  Network& network_;
  const int master_node_;
  Random random_;
  std::vector<One> all_;
  std::uint64_t answers_ = 0;
  bool is_over_ = false;
};

}  // namespace tessera::sim
