// SPDX-License-Identifier: Apache-2.0
// A framed, ordered, bounded byte link to one peer: TLS over TCP, plain TCP on loopback, or a local
// socket pair inside the process. It knows records, not messages.
//
// Threads. Io thread only, unless a function says otherwise. Callbacks come on the io thread, never
// from inside a call of ours, and never after close() or the destructor.
//
// Invariants. (1) Limits of type and length are checked on the record head before a byte is
// allocated for it; the checksum (CRC-32C, links without TLS) before the record is handed on. (2)
// The send queue is bounded by kSendQueueBytesMax. queue_bytes() says how much it holds, and a
// connection whose sender would pass the bound is closed with kResourceExhausted, so that senders
// of bulk data watch on_drained. (3) A started record must be complete within its deadline
// (fault-matrix T_msg). (4) no_delay on both ends.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/net/certificate_life.h"
#include "common/net/link_counters.h"
#include "common/net/record.h"

namespace tessera::net {

inline constexpr std::uint64_t kSendQueueBytesMax = std::uint64_t{64} << 20;
inline constexpr std::uint64_t kSendQueueLowBytes = std::uint64_t{1} << 20;

// Who the peer is, as proven by TLS. Peers of plain and local links have an empty role and may act
// in any.
struct PeerIdentity {
  bool is_authenticated = false;
  std::string role;    // "master", "slave", "app"
  std::string name;    // certificate's common name
  std::string serial;  // certificate's serial number, in hexadecimal digits
  CertificateLife life;
  std::string address;  // "10.0.0.5:41234", or "local"
  std::uint16_t port = 0;
  std::string local_host;  // our own address on this link, without a port; empty: not known
  double rtt_seconds = 0;  // of the TCP handshake; 0 where it is not known
  // The connection has one of the last descriptors (common/base/descriptors.h).
  bool is_in_reserve = false;
};

struct ConnectionCallbacks {
  std::function<void(ReceivedRecord)> on_record;
  // Called once, whatever ended the link (peer closed: kUnavailable; bad bytes: kDataLoss; ...),
  // but not after our own close().
  std::function<void(Status)> on_closed;
  // The send queue fell below kSendQueueLowBytes after having been above: time for more bulk data.
  std::function<void()> on_drained;
};

class Connection {
 public:
  virtual ~Connection() = default;  // closes

  // Begins to read. Call once, with limits for the first records.
  virtual void start(ConnectionCallbacks callbacks, const RecordLimits& limits) = 0;
  virtual void set_limits(const RecordLimits& limits) = 0;  // from the next record on

  // A started record may take so long beside its bytes; as long as a silent peer lives, which the
  // handshake decides. From the next record on. Links whose records come whole have no such time.
  virtual void set_record_grace(std::chrono::milliseconds /*grace*/) {}

  virtual void send(Record record) = 0;  // queued; dropped after close
  virtual std::uint64_t queue_bytes() const = 0;

  // Ends the link as if the peer had: on_closed(why) follows, from the loop's queue and so never
  // from inside a call.
  virtual void end_soon(Status why) = 0;

  // Sends what is queued (for at most `grace`), then closes. No callback follows.
  virtual void close(std::chrono::milliseconds grace = std::chrono::milliseconds(0)) = 0;

  virtual const PeerIdentity& peer() const = 0;
  virtual std::uint64_t bytes_sent() const = 0;
  virtual std::uint64_t bytes_received() const = 0;
  virtual std::chrono::steady_clock::time_point last_received()
      const = 0;  // any byte counts as life
  virtual std::chrono::steady_clock::time_point last_sent() const = 0;
  // This is a system call: use it a few times per second and per bulk record, no more.
  virtual LinkCounters link_counters() const { return {bytes_sent(), {}, {}, {}, queue_bytes()}; }
};

using ConnectionPtr = std::shared_ptr<Connection>;

}  // namespace tessera::net
