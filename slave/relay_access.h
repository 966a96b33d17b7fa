// SPDX-License-Identifier: Apache-2.0
// How a slave reaches other slaves, and is reached by them: what the relay needs of the network,
// bound to this slave's keys by whoever starts it. Without both functions a slave does not relay.
//
// Threads. Called on the node's event loop.
// Invariant. There is a listener only with keys (TLS, role slave of this cluster), or on loopback
// with --plain.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/net/connection.h"
#include "common/net/connector.h"
#include "common/net/endpoint.h"
#include "common/net/listener.h"

namespace tessera::slave {

struct RelayAccess {
  // `local_host`: our own address on the link to the master.
  std::function<Result<std::unique_ptr<net::Listener>>(
      const std::string& local_host, std::function<void(net::ConnectionPtr)> on_accept)>
      listen;
  std::function<std::unique_ptr<net::ConnectAttempt>(
      const net::Endpoint& feeder, std::function<void(Result<net::ConnectionPtr>)> on_connected)>
      connect;
};

}  // namespace tessera::slave
