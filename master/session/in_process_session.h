// SPDX-License-Identifier: Apache-2.0
// The session whose master lives inside this process. The master's slaves may be in this process,
// too, or connect to its listener. Threads and promises: session.h.
#pragma once

#include <memory>

#include "master/session/session.h"

namespace tessera::master {

Result<std::unique_ptr<Session>> open_in_process_session(const SessionOptions& options);

}  // namespace tessera::master
