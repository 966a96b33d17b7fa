// SPDX-License-Identifier: Apache-2.0
// One connection with messages on it: encodes and decodes, keeps the link alive with heartbeats,
// finds a silent peer, measures the round trip. Below it are records, above it the state machines
// of slaves and applications.
//
// Threads. Io thread only. The callbacks may destroy the link they come from.
//
// Invariants. (1) Ping and Pong are handled here and never reach on_message. (2) A link is over
// when it has ended, when its owner has let go of it (close(), refuse(), say_goodbye()) or
// destroyed it: from then on no callback comes, whatever the connection still brings, and the
// callbacks and what they hold are gone as soon as the one that runs has returned. (3) on_ended
// comes at most once, and only to an owner who has not let go.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/base/clock.h"
#include "common/base/limits.h"
#include "common/net/connection.h"
#include "common/net/event_loop.h"
#include "common/net/liveness.h"
#include "common/wire/messages.h"
#include "master/cluster/clock_offset.h"

namespace tessera::master {

// How a peer was silent that was given up for its silence, by what its machine's kernel did.
enum class Silence {
  kWhole,      // nothing came of the machine
  kOneWay,     // its packets came, and what was sent to it was not acknowledged
  kOfProcess,  // the machine acknowledged all; the process was silent
};

class PeerLink {
 public:
  struct Callbacks {
    std::function<void(wire::Message)> on_message;
    std::function<void(Status)> on_ended;
    std::function<void()> on_drained;  // may be null
  };

  // Starts to read. Heartbeats begin with start_heartbeat(); until then the listener watches the
  // time.
  PeerLink(net::EventLoop& io, net::ConnectionPtr connection, const net::RecordLimits& limits,
           Callbacks callbacks);
  ~PeerLink();
  PeerLink(const PeerLink&) = delete;
  PeerLink& operator=(const PeerLink&) = delete;

  // Called by whoever takes the link over after the handshake. Does nothing once the link is over.
  void set_callbacks(Callbacks callbacks);
  void set_limits(const net::RecordLimits& limits) { connection_->set_limits(limits); }
  void start_heartbeat(const net::Pulse& pulse = {});

  // Asks for the round trip and the peer's clock; heartbeats do so, too.
  void ping();

  void send(wire::Message message);
  // Tells the peer why, then closes. No callback comes afterwards.
  void refuse(wire::RefuseCode code, const std::string& reason);
  void close();
  void say_goodbye(const std::string& reason);

  net::Connection& connection() { return *connection_; }
  const net::Connection& connection() const { return *connection_; }
  std::string peer_text() const;  // "slave 'a' at 10.0.0.5:4000", for logs
  double rtt_seconds() const { return rtt_seconds_; }
  // Requires: the link ended with kDeadlineExceeded, for its peer's silence.
  Silence silence() const { return silence_; }
  // How far the peer's clock is from ours; nothing before the first Pong that tells.
  std::optional<ClockEstimate> clock(TimePoint now) const { return clock_.estimate(now); }

 private:
  void on_record(net::ReceivedRecord record);
  void beat();
  void on_pong(const wire::Pong& pong);
  void watch_silence();
  void break_off(const Status& breach);  // tells the peer what it broke
  void end(Status status);
  // Ends the link. Returns: its callbacks, for a last call; what they hold may be our owner, so no
  // member may be touched once they are destroyed.
  [[nodiscard]] Callbacks let_go(std::chrono::milliseconds grace);

  net::ConnectionPtr connection_;
  Callbacks callbacks_;
  net::Timer heartbeat_;
  net::Liveness liveness_{net::Pulse()};
  net::PingAllowance pings_heard_{net::Pulse()};
  double rtt_seconds_ = 0;
  ClockOffset clock_;
  std::deque<TimePoint> pings_;       // ours without an answer, oldest first, at most kPingsMax
  TimePoint pinged_{};                // the last of all
  TimePoint heard_at_{};              // when something last came, as of the last beat
  std::uint64_t segments_heard_ = 0;  // of TCP, as of the first beat after that
  Silence silence_ = Silence::kWhole;
  bool is_over_ = false;
};

}  // namespace tessera::master
