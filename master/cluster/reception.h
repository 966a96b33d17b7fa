// Receives fresh connections: waits for the first message, checks version and role, and hands the
// link on. Until then a peer may say only Hello or Join; the listener watches the time.
//
// Threads. Io thread only.
#pragma once

#include <functional>
#include <list>
#include <memory>

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
  using GuestIterator = std::list<Guest>::iterator;

  void on_first_message(GuestIterator guest, wire::Message message);
  void turn_away(GuestIterator guest, wire::RefuseCode code, const std::string& reason);

  net::EventLoop& io_;
  const Callbacks callbacks_;
  std::list<Guest> guests_;
};

// The highest version that both speak; 0 when there is none.
std::uint16_t common_version(std::uint16_t version_min, std::uint16_t version_max);

// May a peer with this identity act as `role`? Peers that TLS has not identified (loopback, local)
// may be anything.
bool may_act_as(const net::PeerIdentity& peer, wire::Role role);

}  // namespace tessera::master
