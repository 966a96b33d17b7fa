// SPDX-License-Identifier: Apache-2.0
// One interface over the three kinds of byte stream: TLS over TCP, TCP, and a socket pair inside
// the process. For common/net alone. Io thread only.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/base/check.h"
#include "common/base/clock.h"
#include "common/net/connection.h"
#include "common/net/io_thread_asio.h"
#include "common/net/link_counters.h"
#include "common/net/send_queue.h"
#include "common/net/tls_impl.h"
#include "common/net/tls_socket.h"

namespace tessera::net {

using StreamHandler = std::function<void(const asio::error_code&, std::size_t)>;

class ByteStream {
 public:
  virtual ~ByteStream() = default;
  virtual void read_some(std::span<std::byte> buffer, StreamHandler handler) = 0;
  virtual void write_all(const std::vector<asio::const_buffer>& buffers, StreamHandler handler) = 0;
  // Writes as much as the link takes without waiting, of at most kGatherBuffersMax parts. Returns:
  // bytes written; 0 also where the link is broken, which write_all() tells.
  virtual std::size_t write_now(const std::vector<asio::const_buffer>& buffers) = 0;
  virtual void shutdown_send() = 0;
  virtual void close() = 0;
  virtual bool needs_checksum() const = 0;  // TCP without TLS
  // Returns: when bytes last came, those included that read_some() cannot give yet (a part of a TLS
  // record); the epoch for a stream that gives every byte at once.
  virtual TimePoint last_heard() const { return {}; }
  // What the kernel counts of a TCP link; bytes_moved and busy stay 0 elsewhere.
  virtual LinkCounters tcp_counters() const = 0;
};

using TcpSocket = asio::ip::tcp::socket;
using LocalSocket = asio::local::stream_protocol::socket;

std::unique_ptr<ByteStream> make_byte_stream(TcpSocket socket);
std::unique_ptr<ByteStream> make_byte_stream(std::shared_ptr<TlsSocket> socket);
std::unique_ptr<ByteStream> make_byte_stream(LocalSocket socket);

// Address ("10.0.0.5:41234") and port of the peer; empty and 0 when the socket is not connected.
PeerIdentity address_of(const TcpSocket& socket);

}  // namespace tessera::net
