// SPDX-License-Identifier: Apache-2.0
// How scenes come into a slave: the receiver, the slave that may feed it in the master's place, and
// the slaves that it feeds. It does everything of the scene connection except what retirement means
// for built scenes.
//
// What is lacking goes to whoever feeds us at the time: the master, until it names a slave
// (RelayFrom), and again when it names itself. A feeder that fails is reported, and the next word
// of the master awaited; what has come stays.
//
// Threads. The event loop's thread only.
// Invariants. (1) Digests come from the master alone: a chunk of another slave that does not have
// its digest changes nothing, and ends that slave's feeding. (2) Chunks are passed on only after
// they have been checked here.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/base/clock.h"
#include "common/net/event_loop.h"
#include "common/net/listener.h"
#include "common/wire/scene_receiver.h"
#include "slave/relay_child.h"
#include "slave/relay_feeder.h"

namespace tessera::slave {

class SceneIntake {
 public:
  struct Events {
    std::function<void(wire::Message)> send;  // to the master, on the scene connection
    std::function<Status(wire::SceneReceiver::Complete)> complete;
    // Called for a breach of protocol that is found outside of on_message().
    std::function<void(Status)> breach;
  };

  SceneIntake(net::EventLoop& loop, wire::SceneReceiver::Room room, const RelayAccess& access,
              Events events);

  // Listens for slaves to feed, where the access allows, at the address by which the master is
  // reached: a door that was opened before stays open while that is the same. Fills in the fields
  // of the Hello.
  void open_relay(const std::string& local_host, wire::Hello& hello);

  // Returns: a status that is not ok for a breach of protocol.
  Status on_message(wire::Message message);
  Status retire(SceneVersion first_kept);
  // Must be called when the session is gone.
  void lost();
  void close();

 private:
  Status perform(wire::SceneReceiver::Actions actions);
  Status on_relay_from(const wire::RelayFrom& from);
  std::optional<wire::RelayFault> on_relayed_chunk(const wire::SceneChunk& chunk);
  void log_received(const wire::SceneReceiver::Complete& complete);
  void report_progress();

  net::EventLoop& loop_;
  const RelayAccess access_;
  const Events events_;
  wire::SceneReceiver receiver_;
  std::unique_ptr<RelayFeeder> feeder_;  // null: does not relay
  std::unique_ptr<net::Listener> listener_;
  std::string relay_host_;         // where listener_ is; meaningless without, as is the token
  std::uint64_t relay_token_ = 0;  // what those who fetch scenes must say
  std::string relay_failure_;      // logged last
  RelayChild child_;
  // Version whose feeder failed after the master had named it; the master's next word is awaited.
  // 0: none.
  SceneVersion orphan_of_ = 0;
  TimePoint announced_{};            // of the newest scene
  std::uint64_t relayed_bytes_ = 0;  // since the last complete scene, from other slaves
  net::Timer progress_;
  bool is_reporting_ = false;
};

}  // namespace tessera::slave
