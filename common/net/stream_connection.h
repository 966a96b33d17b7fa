// SPDX-License-Identifier: Apache-2.0
// The connection over a stream of bytes: records, checksums, deadlines. For common/net alone.
//
// Threads. Io thread only.
#pragma once

#include <memory>

#include "common/net/byte_stream.h"
#include "common/net/connection.h"

namespace tessera::net {

// Requires: the stream is ready, its TLS handshake done.
ConnectionPtr make_connection(IoThread& io, std::unique_ptr<ByteStream> stream, PeerIdentity peer);

}  // namespace tessera::net
