// SPDX-License-Identifier: Apache-2.0
// How a slave or an application comes by a link to its master: programs pass net::connect(), a
// master's own process a local pair, tests what they like.
//
// Threads. The io thread only, the call back included.
#pragma once

#include <functional>
#include <memory>

#include "common/base/status.h"
#include "common/net/connection.h"
#include "common/net/connector.h"

namespace tessera::net {

// Opens one link. The attempt is given up when the returned handle is destroyed (may be null); the
// call back may come from inside the call.
using LinkFactory = std::function<std::unique_ptr<ConnectAttempt>(
    std::function<void(Result<ConnectionPtr>)> on_connected)>;

}  // namespace tessera::net
