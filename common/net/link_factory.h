// SPDX-License-Identifier: Apache-2.0
// How a slave comes by a link to its master: the daemon passes net::connect(), a master's own
// process a local pair, tests what they like.
//
// Threads. The io thread only, the call back included.
#pragma once

#include <functional>
#include <memory>

#include "common/base/status.h"
#include "common/net/connection.h"
#include "common/net/connector.h"

namespace tessera::slave {

// Opens one link: called first for the tile, then for the scene connection of each session. The
// attempt is given up when the returned handle is destroyed (may be null).
using LinkFactory = std::function<std::unique_ptr<net::ConnectAttempt>(
    std::function<void(Result<net::ConnectionPtr>)> on_connected)>;

}  // namespace tessera::slave
