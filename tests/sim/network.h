// SPDX-License-Identifier: Apache-2.0
// The network of the simulated world: machines on one switch, each with a link of its own (rates,
// delay, jitter), and TCP-like connections over them: ordered and lossless while they live, held up
// by cuts, refused by dead processes, reset on demand. Different connections overtake each other.
//
// The model: a record travels in segments. A connection has one segment on its machine's uplink at
// a time, so connections share it in turns. The segment then takes the link's delay and the
// receiver's downlink. At most `window` bytes are on their way and unread; a cut of either
// direction holds up both (no acknowledgement comes back). What a cut swallowed is sent again some
// time after it has healed.
//
// Threads. The simulation's one.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/net/connection.h"
#include "common/net/connector.h"
#include "tests/sim/process.h"
#include "tests/sim/random.h"

namespace tessera::sim {

struct LinkModel {
  double up_bytes_per_s = 0;    // 0: no limit
  double down_bytes_per_s = 0;  // 0: no limit
  Duration delay{};             // one way, this machine's share
  Duration jitter{};            // at most; uniform
};

class Wire;  // one connection: both its ends

// Callbacks for what the oracle and the trace see of the network. Each may be null.
struct NetworkEvents {
  std::function<void(const Process& from, int to_node, const net::Record&)> on_sent;
  std::function<void(const Process& from, int to_node, std::uint64_t queue_bytes)> on_queued;
};

class Network {
 public:
  using OnAccept = std::function<void(net::ConnectionPtr)>;

  Network(EventQueue& queue, std::uint64_t seed) : queue_(queue), random_(seed) {}
  ~Network();

  NetworkEvents events;

  int add_node(const LinkModel& link);
  // Host of a machine, the address of its connections, and the machine that has a host (-1: none).
  static std::string host_of(int node) {
    return "10.0." + std::to_string(node / 256) + "." + std::to_string(node % 256);
  }
  static std::string address_of(int node) { return host_of(node) + ":40000"; }
  int node_of(const std::string& host) const;
  LinkModel& link(int node) { return nodes_[static_cast<std::size_t>(node)].link; }

  // `process` accepts connections to its machine until it ends; one listener for each machine.
  void listen(Process& process, OnAccept on_accept);
  // Connects as net::connect() does: calls back once, unless the attempt is destroyed before.
  std::unique_ptr<net::ConnectAttempt> connect(
      Process& from, int to_node, std::function<void(Result<net::ConnectionPtr>)> on_connected);

  // What `from` sends does not reach `to` until it is healed.
  void cut(int from, int to) { cuts_.insert({from, to}); }
  void heal(int from, int to);
  void heal_all();
  bool is_cut(int from, int to) const { return cuts_.contains({from, to}); }

  // stall() holds up one direction of the `which`-th oldest connection between two machines, as a
  // middlebox may, or lets it go on. reset() ends both ends of one abruptly.
  void stall(int from, int to, std::size_t which, bool is_stalled);
  void reset(int a, int b, std::size_t which);
  // While it is refusing, the machine trusts no certificate: new connections to it fail, and those
  // that stand live on.
  void set_refusing(int node, bool is_refusing) {
    nodes_[static_cast<std::size_t>(node)].is_refusing = is_refusing;
  }
  void reset_all(int node);  // all connections of a machine
  std::size_t connections_between(int a, int b) { return wires_between(a, b).size(); }

  // The operating system cleans up after a process: its peers hear of it, unless the machine lost
  // its power.
  void on_process_ended(const Process& process, bool is_power_lost);

  std::size_t open_ends(const Process& process) const;
  // When the process last read from the quietest of its open connections to that machine; now when
  // there is none. A connection on which nothing has come yet does not count.
  TimePoint heard_from(const Process& process, int node) const;
  std::uint64_t bytes_between(int from, int to) const;
  void set_window(std::uint64_t bytes) { window_bytes_ = bytes; }

 private:
  friend class Wire;
  struct Node {
    LinkModel link;
    TimePoint up_free{}, down_free{};
    Process* listener = nullptr;
    bool is_refusing = false;
    OnAccept on_accept;
  };
  struct Attempt;

  bool passes(int from, int to) const { return !cuts_.contains({from, to}); }
  Duration travel(int from, int to);  // delay and jitter of both machines
  void try_connect(const std::shared_ptr<Attempt>& attempt, int tries_left);
  std::vector<std::shared_ptr<Wire>> wires_between(int a, int b);

  EventQueue& queue_;
  Random random_;
  std::uint64_t window_bytes_ = 256 * 1024;
  std::vector<Node> nodes_;
  std::set<std::pair<int, int>> cuts_;
  std::vector<std::shared_ptr<Wire>> wires_;
  std::map<std::pair<int, int>, std::uint64_t> bytes_;
};

}  // namespace tessera::sim
