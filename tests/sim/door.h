// SPDX-License-Identifier: Apache-2.0
// The listener of a simulated process: what net::Listener does beside accepting. A connection that
// does not authenticate itself within kHandshakeMs is closed.
//
// Threads. The simulation's one.
#pragma once

#include <cstdint>
#include <map>
#include <memory>

#include "common/net/listener.h"
#include "tests/sim/process.h"

namespace tessera::sim {

class Door final : public net::Listener {
 public:
  // `process` outlives the door, or ends before it.
  Door(Process& process, std::uint16_t port) : process_(process), port_(port) {}

  std::uint16_t port(std::size_t /*endpoint*/) const override { return port_; }
  void mark_authenticated(const net::Connection& connection) override {
    strangers_.erase(&connection);
  }

  // Begins to wait for the connection to authenticate itself.
  void accept(const net::ConnectionPtr& connection);

 private:
  Process& process_;
  const std::uint16_t port_;
  std::map<const net::Connection*, std::weak_ptr<net::Connection>> strangers_;
};

}  // namespace tessera::sim
