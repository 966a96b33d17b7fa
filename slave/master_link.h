// SPDX-License-Identifier: Apache-2.0
// The two connections of a slave to its master as one thing that is either there or not: it
// connects, shakes hands, keeps both alive, and starts over with growing pauses when either is
// lost, or refused for whatever reason: a clock that is set right, a new certificate, a name that
// is given up or another build mends it while the slave stands by.
//
//   idle -> tile link -> Hello/Welcome -> scene link -> Join/Joined -> ready -> (lost) -> idle
//
// Threads. The io thread only, construction and destruction included. Callbacks come on it, too,
// and never from inside start(), send_*() or leave(). Invariants. (1) on_ready and on_lost
// alternate. (2) After leave() no callback follows.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "common/net/backoff.h"
#include "common/net/connection.h"
#include "common/net/connector.h"
#include "common/net/event_loop.h"
#include "common/net/link_counters.h"
#include "common/net/link_factory.h"
#include "common/net/liveness.h"
#include "common/wire/messages.h"

namespace tessera::slave {

struct MasterLinkEvents {
  std::function<void()> on_ready;
  std::function<void()> on_lost;
  // Called before each Hello, which it may complete: only now is it known by which address of ours
  // the master is reached (empty: not known). May be null.
  std::function<void(const std::string& local_host, wire::Hello&)> on_reached = {};
  // A status that is not ok is a breach of protocol: it is told to the master, and the session
  // ends.
  std::function<Status(wire::Message)> on_tile_message;
  std::function<Status(wire::Message)> on_scene_message;
  std::function<void()> on_drained;  // the tile connection takes bulk data again
};

class MasterLink {
 public:
  MasterLink(net::EventLoop& io, wire::Hello hello, net::LinkFactory open_link,
             MasterLinkEvents events);
  ~MasterLink();

  void start();
  bool can_get_certificates() const {
    return state_ == State::kReady && welcome_.issues_certificates;
  }
  void send_tile(wire::Message message);
  void send_scene(wire::Message message);
  std::uint64_t tile_queue_bytes() const;  // 0 when not ready
  net::LinkCounters tile_counters() const;

  // Tells the master that it broke the protocol, and ends the session. For breaches that are found
  // outside of on_..._message.
  void break_off(const Status& why);

  // Says goodbye and closes, sending what is queued for at most `grace`. Nothing is tried again.
  void leave(const std::string& reason, std::chrono::milliseconds grace);

 private:
  enum class State { kIdle, kTileLink, kHello, kSceneLink, kJoin, kReady, kEnded };

  void open(State next);
  void on_opened(Result<net::ConnectionPtr> link);
  void watch(const net::ConnectionPtr& link, bool is_scene);
  void on_record(net::ReceivedRecord record, bool is_scene);
  void on_message(wire::Message message, bool is_scene);
  void on_welcome(const wire::Welcome& welcome);
  void on_refused(const wire::Refuse& refuse);
  void on_joined();
  void on_tick();
  void look_again();
  bool keep_alive(net::Connection& link, net::Liveness& liveness, const char* which);
  void lose(const Status& why);  // closes both and waits for the next attempt
  void lose_for(const Status& why, std::chrono::milliseconds pause);
  void lose_refused(const Status& why);  // one end does not trust or take the other
  void close_links(std::chrono::milliseconds grace);
  void log_waiting(const Status& why, std::chrono::milliseconds pause);

  net::EventLoop& io_;
  wire::Hello hello_;
  const net::LinkFactory open_link_;
  const MasterLinkEvents events_;

  State state_ = State::kIdle;
  std::uint64_t generation_ = 0;  // of the attempt; what comes from an older one is ignored
  net::Backoff backoff_;
  std::unique_ptr<net::ConnectAttempt> attempt_;
  net::ConnectionPtr tile_, scene_;
  net::ConnectionPtr parting_tile_, parting_scene_;  // closing; kept until the next attempt
  wire::Welcome welcome_;
  net::Liveness tile_liveness_, scene_liveness_;
  TimePoint handshake_deadline_{};
  bool was_welcomed_ = false;  // in any session
  bool was_wait_logged_ = false;
  TimePoint wait_logged_{};
  std::string refusal_told_;  // logged last
  net::Timer tick_, retry_;
  std::shared_ptr<int> alive_ = std::make_shared<int>(0);
};

}  // namespace tessera::slave
