// SPDX-License-Identifier: Apache-2.0
// What a link has carried so far and how fast its peer answers, as the kernel counts it.
//
// Threads. Any; the counts are of one moment.
#pragma once

#include <chrono>
#include <cstdint>

namespace tessera::net {

// Counts of one link, from which its speed is judged.
struct LinkCounters {
  std::uint64_t bytes_moved = 0;  // taken by the peer's machine (TCP), else by the socket
  // Time with bytes on the way; 0 for good where nobody measures.
  std::chrono::microseconds busy{0};
  std::chrono::microseconds rtt{0}, rtt_min{0};  // TCP's own: smoothed, and the least ever
  std::uint64_t queue_bytes = 0;                 // waiting in this process
  std::uint64_t on_the_way_bytes = 0;            // with the kernel, not acknowledged
  std::uint64_t segments_heard = 0;              // of TCP, those that brought nothing new, too
};

// Counters of a connected TCP socket; all zero for other sockets. This is a system call.
LinkCounters tcp_counters_of(int socket);

}  // namespace tessera::net
