// SPDX-License-Identifier: Apache-2.0
// A process that speaks to another one as a fuzz input says: it opens links, takes those that come,
// says anything on them, closes them, and lets time pass.
//
// Threads. The simulation's one.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "tests/fuzz/peers/speech.h"
#include "tests/sim/network.h"

namespace tessera::test {

class Stranger {
 public:
  static constexpr std::size_t kLinksMax = 6;
  static constexpr int kStepsMax = 200;

  Stranger(sim::EventQueue& queue, sim::Network& network, int node);
  ~Stranger() { leave(); }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;

  // Takes the links of who connects to its machine.
  void listen();
  // Takes one step of `input`; kinds that it does not know are `other` steps of the test.
  void step(FuzzInput& input, int peer_node, const std::function<void(std::uint8_t)>& other);
  void leave();  // its links are closed by the system

  Heard heard;

 private:
  void call(int node);
  void adopt(net::ConnectionPtr link);
  void on_record(std::size_t link, net::ReceivedRecord record);

  sim::EventQueue& queue_;
  sim::Network& network_;
  std::unique_ptr<sim::Process> process_;
  std::vector<std::unique_ptr<net::ConnectAttempt>> attempts_;
  std::vector<net::ConnectionPtr> links_;  // null: closed
};

// Lets virtual time pass.
void run_for(sim::EventQueue& queue, Duration time);

// Runs the events until `is_done`. Returns: false when it is not after `seconds`.
bool run_until(sim::EventQueue& queue, double seconds, const std::function<bool()>& is_done);

// Says nothing of what peers do wrong; call it once in a process.
void silence_log();

}  // namespace tessera::test
