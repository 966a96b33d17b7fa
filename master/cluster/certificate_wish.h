// SPDX-License-Identifier: Apache-2.0
// A peer's wish for a new certificate, on its way from its link to whoever makes some.
// Threads. The io thread.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/net/connection.h"
#include "common/wire/messages.h"

namespace tessera::master {

// `answer` may be called later, and does nothing where the peer is gone.
using CertificateWish = std::function<void(const net::PeerIdentity&, std::vector<std::byte> request,
                                           std::function<void(wire::CertificateGrant)> answer)>;

}  // namespace tessera::master
