// SPDX-License-Identifier: Apache-2.0
// TLS over a TCP socket without a layer between: OpenSSL reads and writes the socket itself, many
// records a call, and Asio only waits until it is ready. For common/net alone.
//
// Refused: asio::ssl::stream. It carries every record through a pair of buffers, one at a time and
// with a round of the loop for each: five times the cost of the encryption.
//
// Threads. Io thread only. The caller of an operation keeps the socket alive until the handler is
// called; one read and one write may be under way at a time.
#pragma once

#include <openssl/bio.h>
#include <openssl/ssl.h>

#include <asio.hpp>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/base/clock.h"

namespace tessera::net {

class TlsSocket {
 public:
  using Handler = std::function<void(const asio::error_code&, std::size_t)>;

  TlsSocket(asio::ip::tcp::socket socket, SSL_CTX* context);
  ~TlsSocket();
  TlsSocket(const TlsSocket&) = delete;
  TlsSocket& operator=(const TlsSocket&) = delete;

  void handshake_as_server(std::function<void(const asio::error_code&)> handler);
  void handshake_as_client(std::function<void(const asio::error_code&)> handler);

  // Reads at least a byte, and all that is there as far as `buffer` takes it.
  void read_some(std::span<std::byte> buffer, Handler handler);
  void write_all(std::vector<asio::const_buffer> parts, Handler handler);
  // Writes as much as the socket takes. Returns: bytes written; 0 also for an error, which
  // write_all() reports. The next write must begin with the first byte that was not written.
  std::size_t write_now(const std::vector<asio::const_buffer>& parts);

  // When the socket last gave bytes, be it a whole record or a part of one: at 100 kbit/s a record
  // takes 1.3 s, longer than a silent peer lives. The epoch before the first bytes.
  TimePoint last_heard() const { return last_heard_; }

  asio::ip::tcp::socket& socket() { return socket_; }
  SSL* ssl() const { return ssl_.get(); }

 private:
  struct Free {
    void operator()(SSL* ssl) const { SSL_free(ssl); }
  };
  static BIO_METHOD* bio_method();
  void shake(const std::function<void(const asio::error_code&)>& handler);
  std::size_t write_some(const std::vector<asio::const_buffer>& parts, std::size_t skip,
                         asio::error_code& error);
  void write_rest(const std::shared_ptr<std::vector<asio::const_buffer>>& parts,
                  std::size_t written, const Handler& handler);
  // Returns: whether the last call of OpenSSL is to be repeated when the socket is ready, which
  // `again` is called for; if not, `error` says why.
  bool wait_for_socket(int result, std::function<void(const asio::error_code&)> again,
                       asio::error_code& error);

  asio::ip::tcp::socket socket_;
  std::unique_ptr<SSL, Free> ssl_;
  TimePoint last_heard_{};
};

}  // namespace tessera::net
