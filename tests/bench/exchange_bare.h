// SPDX-License-Identifier: Apache-2.0
// The bare epoll loop: reads results, writes requests, does nothing else. C sockets.
//
// Threads. One.
#pragma once

namespace tessera::bench {

struct ExchangeRate {
  double exchanges_per_second = 0;
  double cpu_us = 0;  // of the thread that does it, per exchange
};

// `window` requests are out on each connection.
ExchangeRate measure_bare_exchange(int connections, int window, double seconds);

}  // namespace tessera::bench
