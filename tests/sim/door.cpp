// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/door.h"

#include "common/base/limits.h"

namespace tessera::sim {

void Door::accept(const net::ConnectionPtr& connection) {
  strangers_[connection.get()] = connection;
  process_.run_at(process_.queue().now() + std::chrono::milliseconds(kHandshakeMs),
                  Duration::zero(), [this, connection = std::weak_ptr(connection)] {
                    const auto late = connection.lock();
                    if (!late || strangers_.erase(late.get()) == 0) return;
                    late->end_soon(Status::deadline_exceeded("the handshake took too long"));
                  });
}

}  // namespace tessera::sim
