// SPDX-License-Identifier: Apache-2.0
// The other side of the exchange benchmark, in a process of its own so that its work is not the
// master's: slaves that answer each lease at once with ready-made pixels, and bare clients that
// answer each request of 64 bytes with as many bytes as a tile has.
//
// Threads. The child is forked before the caller has any threads, and has one itself.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace tessera::bench {

inline constexpr std::size_t kRequestBytes = 64;
inline constexpr std::size_t kResultBytes = 6 * 1024;

struct ExchangePeers {
  int connections = 8;
  int threads = 4;          // that each slave says it has; four leases come for each
  bool is_bare = false;     // no protocol: requests and results by their length alone
  std::string keys_folder;  // of the cluster; empty: plain TCP
};

// A child process. It connects when it is told the port, and ends with its parent or in the
// destructor.
class ExchangeProcess {
 public:
  explicit ExchangeProcess(const ExchangePeers& peers);
  ~ExchangeProcess();  // ends it
  ExchangeProcess(const ExchangeProcess&) = delete;
  ExchangeProcess& operator=(const ExchangeProcess&) = delete;

  void connect_to(std::uint16_t port);
  double cpu_seconds() const;  // so far

 private:
  pid_t child_ = -1;
  int port_pipe_ = -1;
};

}  // namespace tessera::bench
