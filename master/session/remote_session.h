// SPDX-License-Identifier: Apache-2.0
// The session whose master is a running `tessera-master serve` (role app): scene blocks go up,
// finished frames come down. Once it was there the master may go and come again (lasting_client.h).
// fetch_status() is the short exchange behind `tessera-master status`.
// Threads and promises: session.h.
#pragma once

#include <memory>

#include "master/session/session.h"

namespace tessera::master {

Result<std::unique_ptr<Session>> open_remote_session(const SessionOptions& options);

// Connects with role status, asks once, disconnects.
Result<ClusterStatus> fetch_status(const SessionOptions& options);

}  // namespace tessera::master
