// SPDX-License-Identifier: Apache-2.0
// The plainest sockets that do the exchange: epoll, one buffer each way, TLS by OpenSSL where asked
// for. The master's own connections (common/net) are measured against them, so they use none of
// their code.
//
// Threads. One.
#pragma once

#include <openssl/ssl.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/net/cluster_authority.h"

namespace tessera::bench {

class BenchSocket {
 public:
  static BenchSocket connect(std::uint16_t port);  // on loopback; aborts when nobody is there
  explicit BenchSocket(int file);                  // takes it over
  BenchSocket(BenchSocket&& other) noexcept;
  BenchSocket& operator=(BenchSocket&&) = delete;
  ~BenchSocket();

  // Shakes hands as the client with this certificate and does not verify the peer. Blocks.
  void start_tls(const net::KeyPair& own, X509* ca);

  // Appends the bytes that have arrived. Before BenchLoop::add() the socket blocks, and at least
  // one byte is read. Returns: whether the link still stands.
  bool read_into(std::vector<std::byte>& in);
  void put(std::span<const std::byte> bytes) {
    out_.insert(out_.end(), bytes.begin(), bytes.end());
  }
  void flush();  // as much of what was put as the link takes

  int file() const { return file_; }
  bool has_rest() const { return sent_ < out_.size(); }

 private:
  int file_ = -1;
  SSL* ssl_ = nullptr;
  std::vector<std::byte> out_;
  std::size_t sent_ = 0;
};

// Waits for many sockets at once, edge-triggered (EPOLLET).
class BenchLoop {
 public:
  BenchLoop();
  ~BenchLoop();
  BenchLoop(const BenchLoop&) = delete;
  BenchLoop& operator=(const BenchLoop&) = delete;

  // From now on the socket does not block. `on_input` reads all there is.
  void add(BenchSocket& socket, std::function<void()> on_input);
  void run_once(int timeout_ms);

 private:
  struct Entry {
    BenchSocket* socket;
    std::function<void()> on_input;
  };
  const int epoll_;
  std::vector<std::unique_ptr<Entry>> entries_;
};

}  // namespace tessera::bench
