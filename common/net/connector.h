// SPDX-License-Identifier: Apache-2.0
// The calling end of links: one attempt to connect, with a deadline.
//
// Threads. Io thread only.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/net/connection.h"
#include "common/net/endpoint.h"
#include "common/net/io_thread.h"
#include "common/net/tls.h"

namespace tessera::net {

// Connects once: resolve, TCP, TLS, within `deadline`. Calls back exactly once on the io thread
// unless the returned handle is destroyed before. Io thread only. Errors: kUnavailable (not there,
// does not resolve), kPermissionDenied (certificate refused, either side).
class ConnectAttempt {
 public:
  virtual ~ConnectAttempt() = default;
};
std::unique_ptr<ConnectAttempt> connect(IoThread& io, const Endpoint& endpoint,
                                        std::shared_ptr<TlsContext> tls, std::string expected_role,
                                        std::chrono::milliseconds deadline,
                                        std::function<void(Result<ConnectionPtr>)> on_connected);

}  // namespace tessera::net
