// SPDX-License-Identifier: Apache-2.0
// A link inside the process: a socket pair, for a master that has a slave in itself and for tests.
//
// Threads. Any, but each end is then used on its own io thread only; the two may be the same.
#pragma once

#include <utility>

#include "common/net/connection.h"
#include "common/net/io_thread.h"

namespace tessera::net {

// Both ends of one link.
std::pair<ConnectionPtr, ConnectionPtr> make_local_pair(IoThread& a, IoThread& b);

}  // namespace tessera::net
