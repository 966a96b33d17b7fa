// SPDX-License-Identifier: Apache-2.0
// The fed side of the relay: it connects to the slave that the master names, says that slave's
// token, asks for what is lacking and hands over what comes. Any fault ends it with one word to the
// owner, who tells the master; it does not try again by itself. When a version is complete the
// connection stays, for the next one: its keys are agreed and its window is open.
//
// Threads. The event loop's thread only; callbacks come on it, never from inside a call of ours.
// Invariants. (1) At most one feeder at a time. (2) After stop() or on_failed nothing comes. (3) A
// feeder that goes while nothing is wanted of it is no fault.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/net/connector.h"
#include "common/net/event_loop.h"
#include "common/wire/messages.h"
#include "common/wire/scene_receiver.h"
#include "slave/relay_access.h"

namespace tessera::slave {

// What becomes of a feeder by the verdict on a chunk that it sent; nothing: it feeds on. Where
// there is no memory here, the master's chunk is the one that fails the version, and the feeder is
// left without blame.
std::optional<wire::RelayFault> relay_fault_of(wire::SceneReceiver::Verdict verdict);

class RelayChild {
 public:
  struct Events {
    // Returns: why the feeder is given up; nothing: it feeds on.
    std::function<std::optional<wire::RelayFault>(const wire::SceneChunk&)> on_chunk;
    std::function<void(wire::RelayFailed)> on_failed;
  };

  RelayChild(net::EventLoop& loop, const RelayAccess& access, Events events)
      : loop_(loop), access_(access), events_(std::move(events)) {}
  ~RelayChild() { stop(); }

  // Takes this feeder in the place of the one before.
  void follow(const wire::RelayFrom& from, std::vector<wire::SceneChunkNeed> needs);
  // Requires: is_following(need.version).
  void want(wire::SceneChunkNeed need);
  bool is_following(SceneVersion version) const { return version_ == version && version != 0; }
  // Must be called when the version is complete; the connection stays.
  void rest();
  void stop();

 private:
  void connect(const wire::RelayFrom& from);
  void send_waiting();
  void on_connected(Result<net::ConnectionPtr> connection);
  void on_record(net::ReceivedRecord record);
  void fail(wire::RelayFault fault, const std::string& reason);

  net::EventLoop& loop_;
  const RelayAccess& access_;
  const Events events_;
  SceneVersion version_ = 0;  // 0: nothing is wanted
  SessionId feeder_ = 0;
  std::uint64_t token_ = 0;
  std::uint64_t generation_ = 0;  // of the feeder; what comes from an older one is ignored
  std::unique_ptr<net::ConnectAttempt> attempt_;
  net::ConnectionPtr connection_;
  std::vector<wire::SceneChunkNeed> waiting_;  // until the connection stands
  std::shared_ptr<int> alive_ = std::make_shared<int>(0);
};

}  // namespace tessera::slave
