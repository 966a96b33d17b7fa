// SPDX-License-Identifier: Apache-2.0
// The waiting end of links: takes TCP connections, proves who they are, and hands them on.
//
// Threads. Io thread only, on_accept included.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/base/status.h"
#include "common/net/connection.h"
#include "common/net/endpoint.h"
#include "common/net/io_thread.h"
#include "common/net/tls.h"

namespace tessera::net {

// Accepts until destroyed. TLS handshakes (kHandshakeMs) are done before on_accept. The caps of
// limits.h on unauthenticated connections, per address and in all, are kept here; the oldest are
// dropped first. A handed-on connection counts as unauthenticated until mark_authenticated().
class Listener {
 public:
  virtual ~Listener() = default;
  // Port of the n-th endpoint; where port 0 was asked for, the one that the system chose.
  virtual std::uint16_t port(std::size_t endpoint = 0) const = 0;
  virtual void mark_authenticated(const Connection& connection) = 0;
};
// `tls` null: plain TCP; the caller has checked that the endpoint is on loopback and this is
// wanted.
// Returns: kUnavailable naming address and reason (port in use, name does not resolve).
Result<std::unique_ptr<Listener>> listen(IoThread& io, const Endpoint& endpoint,
                                         std::shared_ptr<TlsContext> tls,
                                         std::function<void(ConnectionPtr)> on_accept);
// Listens on several endpoints at once, under the same caps together. Requires: at least one
// endpoint. Returns: what is wrong with the first that cannot be had.
Result<std::unique_ptr<Listener>> listen_on_all(IoThread& io,
                                                const std::vector<Endpoint>& endpoints,
                                                std::shared_ptr<TlsContext> tls,
                                                std::function<void(ConnectionPtr)> on_accept);

}  // namespace tessera::net
