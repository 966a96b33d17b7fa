// SPDX-License-Identifier: Apache-2.0
// This function has a file of its own, because the kernel's tcp_info has more fields than the C
// library's of the same name.
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>

#include "common/net/link_counters.h"

namespace tessera::net {

LinkCounters tcp_counters_of(int socket) {
  tcp_info info{};
  socklen_t size = sizeof(info);
  LinkCounters counters;
  const bool is_tcp = ::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) == 0;
  if (!is_tcp || size < offsetof(tcp_info, tcpi_rwnd_limited))
    return counters;  // before Linux 4.10
  counters.bytes_moved = info.tcpi_bytes_acked;
  counters.on_the_way_bytes =
      std::uint64_t{info.tcpi_unacked} * info.tcpi_snd_mss + info.tcpi_notsent_bytes;
  counters.segments_heard = info.tcpi_segs_in;
  counters.busy = std::chrono::microseconds(info.tcpi_busy_time);
  counters.rtt = std::chrono::microseconds(info.tcpi_rtt);
  counters.rtt_min = std::chrono::microseconds(info.tcpi_min_rtt);
  return counters;
}

}  // namespace tessera::net
