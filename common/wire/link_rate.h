// SPDX-License-Identifier: Apache-2.0
// Measures how fast a link carries bytes, from the counters of its connection: bytes moved over the
// time in which there was something to move, while a queue stood somewhere on the way. A link that
// never queues has no rate: it is faster than what it is given.
//
// A queue stands when bytes wait in the connection; or when at least kOnTheWayMin bytes are on the
// way before more are added, and the round trip has grown to twice its least and by at least
// kQueueingMin. The second rule is for results that are leased a few at a time: they fit into the
// buffers between the machines and never wait in ours. The round trip alone would not do: an
// acknowledgement may be put off by 40 ms on an idle link, but never for more than the last two
// segments. And what is given to the link at once, and looked at when all of it has gone, shows the
// rate if it took much longer than that.
//
// Threads. One owner. Pure: the counters come in, no clock is read.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "common/net/link_counters.h"

namespace tessera::wire {

class LinkRate {
 public:
  // Below these a standing queue is noise, and the bytes in it are not worth coding.
  static constexpr std::chrono::microseconds kQueueingMin{2000};
  static constexpr std::uint64_t kOnTheWayMin = 4 * 1460;
  // Busy time after which there is a first rate, and busy time with which the past counts at most
  // beside the present.
  static constexpr std::chrono::microseconds kBusyMin{20'000}, kMemory{1'000'000};

  void observe(const net::LinkCounters& counters);

  // Bytes per second; nothing as long as the link has not been seen with a queue.
  std::optional<double> bytes_per_second() const;

 private:
  std::optional<net::LinkCounters> last_;
  double bytes_ = 0, busy_seconds_ = 0;
  // Busy time and bytes without a queue since one was last seen; they show a link that became fast.
  double free_seconds_ = 0, free_bytes_ = 0;
};

}  // namespace tessera::wire
