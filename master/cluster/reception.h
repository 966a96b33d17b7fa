// SPDX-License-Identifier: Apache-2.0
// Receives fresh connections: waits for the first message, checks version and role, and hands the
// link on. Until then a peer may say only Hello or Join; the listener watches the time.
//
// Threads. Io thread only.
//
// Invariant. Callbacks of links look their guest up by number; for a guest that is gone they do
// nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/net/event_loop.h"
#include "common/net/listener.h"
#include "master/cluster/peer_link.h"

namespace tessera::master {

class Reception {
 public:
  struct Callbacks {
    std::function<void(std::unique_ptr<PeerLink>, wire::Hello, std::uint16_t version)> on_hello;
    std::function<void(std::unique_ptr<PeerLink>, wire::Join)> on_join;
  };

  Reception(net::EventLoop& io, Callbacks callbacks) : io_(io), callbacks_(std::move(callbacks)) {}

  // `listener` may be null (local pairs).
  void receive(net::ConnectionPtr connection, net::Listener* listener);
  void close_all() { guests_.clear(); }

 private:
  struct Guest {
    std::unique_ptr<PeerLink> link;
    net::Listener* listener = nullptr;
  };
  using GuestNumber = std::uint64_t;  // in order of arrival

  void on_first_message(GuestNumber number, wire::Message message);
  void on_left(GuestNumber number, const Status& status);
  void turn_away(GuestNumber number, wire::RefuseCode code, const std::string& reason);
  // Takes the guest's link out and gives it the limits of a session. Requires: the guest is here.
  std::unique_ptr<PeerLink> let_in(GuestNumber number);

  net::EventLoop& io_;
  const Callbacks callbacks_;
  std::map<GuestNumber, Guest> guests_;
  GuestNumber next_guest_ = 0;
};

// The highest version that both speak; 0 when there is none.
std::uint16_t common_version(std::uint16_t version_min, std::uint16_t version_max);

// With keys a slave's name is that of its certificate, whatever it calls itself: so nobody stands
// in a log, or is held back, in the place of another. Returns: the name in force; empty for a
// certificate without one.
std::string name_in_force(const net::PeerIdentity& peer, const wire::Hello& hello);

// May a peer with this identity act as `role`? Peers that TLS has not identified (loopback, local)
// may be anything.
bool may_act_as(const net::PeerIdentity& peer, wire::Role role);

}  // namespace tessera::master
