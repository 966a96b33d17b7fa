// SPDX-License-Identifier: Apache-2.0
#include "common/net/local_pair.h"

#include <sys/socket.h>

#include "common/net/stream_connection.h"

namespace tessera::net {

std::pair<ConnectionPtr, ConnectionPtr> make_local_pair(IoThread& a, IoThread& b) {
  int ends[2] = {-1, -1};
  TESSERA_CHECK_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
  const int buffer_bytes = 1 << 20;  // one large tile; fewer wake-ups
  for (const int end : ends) {
    ::setsockopt(end, SOL_SOCKET, SO_SNDBUF, &buffer_bytes, sizeof(buffer_bytes));
  }
  PeerIdentity peer;
  peer.address = "local";
  const asio::local::stream_protocol protocol;
  return {
      make_connection(a, make_byte_stream(LocalSocket(context_of(a), protocol, ends[0])), peer),
      make_connection(b, make_byte_stream(LocalSocket(context_of(b), protocol, ends[1])), peer)};
}

}  // namespace tessera::net
