// SPDX-License-Identifier: Apache-2.0
// One simulated connection: two ends, each a net::Connection of one process, and what is on the way
// between them. See network.h for the model.
//
// Threads. The simulation's one.
// Invariants. (1) Records come out in the order in which they went in, whole, once. (2) After
// close() or the end's destruction no callback of that end runs.
#pragma once

#include <deque>
#include <memory>

#include "common/net/record_head.h"
#include "tests/sim/network.h"

namespace tessera::sim {

class Wire : public std::enable_shared_from_this<Wire> {
 public:
  Wire(Network& network, Process& a, Process& b);

  // Makes the connection object of side 0 or 1. Requires: called once for each side.
  net::ConnectionPtr make_end(int side);

  bool is_over() const;  // both ends closed
  bool connects(int a, int b) const;
  int node(int side) const { return ends_[side].node; }
  bool belongs_to(int side, const Process& process) const {
    return ends_[side].process == &process && ends_[side].state != State::kDead;
  }
  bool is_open(int side) const { return ends_[side].state == State::kOpen; }

  void set_stalled(int from_side, bool is_stalled);
  void wake();                          // a cut has healed
  void kill(int side, bool is_silent);  // the process is gone
  void reset();                         // both ends hear of it
  void end(int side, Status status);    // as if the peer had ended it

  // ---- for the ends
  void start(int side, net::ConnectionCallbacks callbacks, const net::RecordLimits& limits);
  void send(int side, net::Record record);
  void close(int side, Duration grace);

  enum class State { kOpen, kClosing, kClosed, kDead };
  struct Outgoing {
    net::Record record;
    std::uint64_t total_bytes = 0, sent_bytes = 0;
  };
  struct Segment {
    std::uint64_t bytes = 0;
    bool is_last = false;  // of its record
    bool is_fin = false;
    net::Record record;  // with the last segment
  };
  struct End {
    Process* process = nullptr;  // null: gone
    int node = 0;
    State state = State::kOpen;
    bool is_started = false;
    net::ConnectionCallbacks callbacks;
    net::RecordLimits limits{};
    net::PeerIdentity peer;
    std::uint64_t bytes_sent = 0, bytes_received = 0;
    TimePoint last_sent, last_received;
    // State of the direction towards the other end.
    std::deque<Outgoing> queue;
    std::uint64_t queue_bytes = 0, unread_bytes = 0;
    bool was_above_low = false, is_transmitting = false, is_stalled = false, is_fin_sent = false;
    TimePoint last_arrival{}, held_since{};
    bool is_held = false;
    std::deque<Segment> arrived;  // read by nobody yet
  };
  const End& end_of(int side) const { return ends_[side]; }
  void set_limits(int side, const net::RecordLimits& limits) { ends_[side].limits = limits; }

 private:
  void pump(int side);
  bool send_segment(int side);
  void transmit(int side, Segment segment);
  void arrive(int side, Segment segment);
  void take(int side);
  void deliver(int side, Segment segment);
  void tell_closed(int side, Status status);
  void drop_queue(End& end);

  Network& network_;
  End ends_[2];
};

}  // namespace tessera::sim
