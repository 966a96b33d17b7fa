// A framed, ordered, bounded byte link to one peer: TLS over TCP, plain TCP on loopback, or a local
// socket pair inside the process. Knows records, not messages.
//
// Threads. Io thread only, unless a function says otherwise. Callbacks come on the io thread, never
// from inside a call of ours, and never after close() or the destructor.
//
// Invariants. (1) Limits of type and length are checked on the record head before a byte is
// allocated for it; the checksum (CRC-32C, links without TLS) before the record is handed on. (2)
// The send queue is bounded by kSendQueueBytesMax; queue_bytes() tells, and a sender that would
// pass it is closed with kResourceExhausted: callers of bulk data watch on_drained. (3) A started
// record must be complete within its deadline (fault-matrix T_msg). (4) no_delay on both ends.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/net/io_thread.h"
#include "common/net/record.h"
#include "common/net/tls.h"

namespace tessera::net {

inline constexpr std::uint64_t kSendQueueBytesMax = std::uint64_t{64} << 20;
inline constexpr std::uint64_t kSendQueueLowBytes = std::uint64_t{1} << 20;

// What the link has carried so far, for whoever judges its speed.
struct LinkCounters {
  std::uint64_t bytes_moved = 0;  // taken by the peer's machine (TCP), by the socket else
  std::chrono::microseconds busy{
      0};  // time with bytes on the way; 0 for good where nobody measures
  std::chrono::microseconds rtt{0}, rtt_min{0};  // TCP's own: smoothed, and the least ever
  std::uint64_t queue_bytes = 0;                 // waiting in us
  std::uint64_t on_the_way_bytes = 0;            // with the kernel, not acknowledged
};

// Who the peer is, as proven by TLS; plain and local links have an empty role, and may take any.
struct PeerIdentity {
  bool is_authenticated = false;
  std::string role;     // "master", "slave", "app"
  std::string name;     // certificate's common name
  std::string serial;   // certificate's serial number, in hexadecimal digits
  std::string address;  // "10.0.0.5:41234", or "local"
  std::uint16_t port = 0;
  double rtt_seconds = 0;  // of the TCP handshake; 0 where there was none
};

struct ConnectionCallbacks {
  std::function<void(ReceivedRecord)> on_record;
  // Once, whatever ended the link (peer closed: kUnavailable; bad bytes: kDataLoss; ...). Not after
  // our own close().
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

  virtual void send(Record record) = 0;  // queued; dropped after close
  virtual std::uint64_t queue_bytes() const = 0;

  // Sends what is queued (for at most `grace`), then closes. No callback follows.
  virtual void close(std::chrono::milliseconds grace = std::chrono::milliseconds(0)) = 0;

  virtual const PeerIdentity& peer() const = 0;
  virtual std::uint64_t bytes_sent() const = 0;
  virtual std::uint64_t bytes_received() const = 0;
  virtual std::chrono::steady_clock::time_point last_received()
      const = 0;  // any byte counts as life
  virtual std::chrono::steady_clock::time_point last_sent() const = 0;
  // A system call: a few times per second and per bulk record, no more.
  virtual LinkCounters link_counters() const { return {bytes_sent(), {}, {}, {}, queue_bytes()}; }
};

using ConnectionPtr = std::shared_ptr<Connection>;

// Two ends of one link inside the process, each on its own io thread (they may be the same).
// Any thread, but each end is then used on its io thread only.
std::pair<ConnectionPtr, ConnectionPtr> make_local_pair(IoThread& a, IoThread& b);

// ---- listening
// -----------------------------------------------------------------------------------------
struct Endpoint {
  std::string host;  // name, IPv4 or IPv6 (without brackets)
  std::uint16_t port = 0;
  std::string text() const;  // "host:port", IPv6 in brackets
};
// "host:port", "[::1]:7400", ":7400" (all interfaces). Returns: kInvalidArgument.
Result<Endpoint> parse_endpoint(const std::string& text);
// Several of them, with commas in between: a machine with more than one link listens on each.
Result<std::vector<Endpoint>> parse_endpoints(const std::string& text);
bool is_loopback(
    const Endpoint& endpoint);  // resolves "localhost"; false for what does not resolve

// Accepts until destroyed. TLS handshakes (kHandshakeMs) are done before on_accept; caps of
// limits.h on unauthenticated connections, per address and in all, are kept here, oldest dropped
// first. A handed-on connection counts as unauthenticated until mark_authenticated().
class Listener {
 public:
  virtual ~Listener() = default;
  // Of the n-th endpoint; the one chosen when asked for 0.
  virtual std::uint16_t port(std::size_t endpoint = 0) const = 0;
  virtual void mark_authenticated(const Connection& connection) = 0;
};
// tls null: plain; the caller has checked that this is loopback and wanted.
// Returns: kUnavailable naming address and reason (port in use, name does not resolve).
Result<std::unique_ptr<Listener>> listen(IoThread& io, const Endpoint& endpoint,
                                         std::shared_ptr<TlsContext> tls,
                                         std::function<void(ConnectionPtr)> on_accept);
// On several links at once, under the same caps together. Requires: at least one endpoint. Returns:
// what is wrong with the first that cannot be had.
Result<std::unique_ptr<Listener>> listen_on_all(IoThread& io,
                                                const std::vector<Endpoint>& endpoints,
                                                std::shared_ptr<TlsContext> tls,
                                                std::function<void(ConnectionPtr)> on_accept);

// Connects once: resolve, TCP, TLS, within `deadline`. Calls back exactly once on the io thread
// unless the returned handle is destroyed before. Io thread only. Errors: kUnavailable (not there,
// does not resolve), kPermissionDenied (certificate refused, either side).
class ConnectAttempt {
 public:
  virtual ~ConnectAttempt() = default;
};
std::unique_ptr<ConnectAttempt> connect(IoThread& io, const Endpoint& endpoint,
                                        std::shared_ptr<TlsContext> tls, std::string expected_role,
                                        std::chrono::milliseconds deadline,
                                        std::function<void(Result<ConnectionPtr>)> on_connected);

}  // namespace tessera::net
