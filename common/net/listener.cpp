// SPDX-License-Identifier: Apache-2.0
#include "common/net/listener.h"

#include <algorithm>
#include <cerrno>
#include <deque>
#include <list>
#include <optional>
#include <utility>

#include "common/base/clock.h"
#include "common/base/descriptors.h"
#include "common/base/limits.h"
#include "common/base/log.h"
#include "common/net/accept_rate.h"
#include "common/net/net_metrics.h"
#include "common/net/stream_connection.h"

namespace tessera::net {
namespace {

using Tcp = asio::ip::tcp;
constexpr std::chrono::milliseconds kSweep{250};
constexpr std::chrono::minutes kTellOutPause{1};
constexpr std::chrono::milliseconds kFarewell{500};  // to say why a peer is refused

// A peer that has not proven itself: in its TLS handshake, or handed on and not yet marked.
struct Pending {
  std::string address;                          // without the port
  std::chrono::steady_clock::time_point since;  // oldest first in the list
  std::shared_ptr<TlsSocket> handshaking;       // null once handed on
  std::weak_ptr<Connection> connection;
};

// State of a listener; pending operations keep it alive.
class Acceptor : public std::enable_shared_from_this<Acceptor> {
 public:
  Acceptor(IoThread& io, std::shared_ptr<TlsContext> tls,
           std::function<void(ConnectionPtr)> on_accept)
      : io_(io), tls_(std::move(tls)), on_accept_(std::move(on_accept)), sweep_(io) {}

  Status open(const Endpoint& endpoint);  // adds one to listen on
  void start();
  void close();
  std::uint16_t port(std::size_t endpoint) const { return ports_[endpoint]; }
  void mark_authenticated(const Connection& connection);

 private:
  void accept_next(Tcp::acceptor& acceptor);
  void on_socket(Tcp::socket socket);
  void make_room(const std::string& address);
  void crowd_out(std::list<Pending>::iterator pending);
  void drop(std::list<Pending>::iterator pending, const char* reason);
  void handshake(Tcp::socket socket, const std::string& address);
  void refuse(std::list<Pending>::iterator pending, PeerIdentity identity,
              const HandshakeFailure& refusal);
  void hand_on(std::list<Pending>::iterator pending, std::unique_ptr<ByteStream> stream,
               PeerIdentity identity);
  void sweep();
  std::size_t open_count();
  PeerIdentity identity_at_door(Tcp::socket& socket);
  void tell_out_of_descriptors();

  IoThread& io_;
  const std::shared_ptr<TlsContext> tls_;
  std::function<void(ConnectionPtr)> on_accept_;
  std::deque<Tcp::acceptor> acceptors_;  // a deque, since handlers refer to its elements
  std::vector<std::uint16_t> ports_;
  std::list<Pending> pending_;
  std::vector<std::weak_ptr<Connection>> authenticated_;
  AcceptRate rate_;
  Timer sweep_;
  std::optional<TimePoint> told_out_;  // when it was last said that there are no descriptors
  bool is_closed_ = false;
};

// The log itself limits how many of these lines are written (log_limiter.h).
void log_failure(const std::string& address, const std::string& reason,
                 const std::string& subject = "") {
  log_warn("handshake-failed", "a peer was not let in: " + reason,
           {{"address", address}, {"subject", subject.empty() ? "unknown" : subject}});
}

void turn_away(Tcp::socket socket, const std::string& address) {
  net_metrics().over_rate.add();
  log_warn("connection-refused", "too many connections from this address in a short time",
           {{"address", address}});
  asio::error_code ignored;
  // A reset ends the connection, so that the kernel keeps nothing of it.
  socket.set_option(asio::socket_base::linger(true, 0), ignored);
  socket.close(ignored);
}

Status Acceptor::open(const Endpoint& endpoint) {
  asio::error_code error;
  Tcp::resolver resolver(context_of(io_));
  const auto results =
      resolver.resolve(endpoint.host, std::to_string(endpoint.port), Tcp::resolver::passive, error);
  if (error || results.empty()) {
    return Status::unavailable("cannot listen on " + endpoint.text() +
                               ": the name does not resolve to an address");
  }
  const Tcp::endpoint address = results.begin()->endpoint();
  Tcp::acceptor& acceptor = acceptors_.emplace_back(context_of(io_));
  acceptor.open(address.protocol(), error);
  if (!error) acceptor.set_option(Tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(address, error);
  if (!error) acceptor.listen(kConnectionsPreAuthMax, error);
  if (error) {
    const char* mend = error == asio::error::address_in_use
                           ? "; stop the other program or choose another port"
                           : "";
    return Status::unavailable("cannot listen on " + endpoint.text() + ": " + error.message() +
                               mend);
  }
  ports_.push_back(acceptor.local_endpoint(error).port());
  return Status::ok();
}

void Acceptor::start() {
  sweep_.start_repeating(kSweep, [this] { sweep(); });
  for (Tcp::acceptor& acceptor : acceptors_) accept_next(acceptor);
}

void Acceptor::accept_next(Tcp::acceptor& acceptor) {
  acceptor.async_accept(
      [self = shared_from_this(), &acceptor](const asio::error_code& error, Tcp::socket socket) {
        if (self->is_closed_) return;
        if (error) {  // out of descriptors, or the peer left already: pause, then go on
          if (error == asio::error::no_descriptors || error.value() == ENFILE) {
            self->tell_out_of_descriptors();
          } else {
            log_failure("", "accept: " + error.message());
          }
          auto pause = std::make_shared<asio::steady_timer>(context_of(self->io_),
                                                            std::chrono::milliseconds(100));
          pause->async_wait([self, pause, &acceptor](const asio::error_code&) {
            if (!self->is_closed_) self->accept_next(acceptor);
          });
          return;
        }
        self->on_socket(std::move(socket));
        self->accept_next(acceptor);
      });
}

std::size_t Acceptor::open_count() {
  std::erase_if(authenticated_, [](const auto& connection) { return connection.expired(); });
  return authenticated_.size() + pending_.size();
}

void Acceptor::on_socket(Tcp::socket socket) {
  asio::error_code error;
  const auto endpoint = socket.remote_endpoint(error);
  if (error || open_count() >= kConnectionsMax) return;
  const std::string address = endpoint.address().to_string();
  if (!rate_.admit(address, Clock::now())) return turn_away(std::move(socket), address);
  socket.set_option(Tcp::no_delay(true), error);
  make_room(address);
  if (tls_) return handshake(std::move(socket), address);
  PeerIdentity identity = identity_at_door(socket);
  pending_.push_back({address, std::chrono::steady_clock::now(), nullptr, {}});
  hand_on(std::prev(pending_.end()), make_byte_stream(std::move(socket)), std::move(identity));
}

PeerIdentity Acceptor::identity_at_door(Tcp::socket& socket) {
  PeerIdentity identity = address_of(socket);
  identity.is_in_reserve = is_in_reserve(socket.native_handle(), descriptor_limit());
  if (identity.is_in_reserve) tell_out_of_descriptors();
  return identity;
}

// One line a minute: peers come again and again.
void Acceptor::tell_out_of_descriptors() {
  const TimePoint now = Clock::now();
  if (told_out_ && now - *told_out_ < kTellOutPause) return;
  told_out_ = now;
  log_warn("out-of-descriptors",
           "no files or connections are left but those kept for status and for slaves that are "
           "here; raise the limit (ulimit -n, LimitNOFILE=)",
           {{"limit", std::to_string(descriptor_limit())}});
}

// Drops the oldest first, so that a good peer still gets in while idle ones wait.
void Acceptor::make_room(const std::string& address) {
  const auto of_address = [&](const Pending& p) { return p.address == address; };
  if (std::count_if(pending_.begin(), pending_.end(), of_address) >=
      kConnectionsPreAuthPerAddressMax) {
    crowd_out(std::find_if(pending_.begin(), pending_.end(), of_address));
  }
  if (pending_.size() >= kConnectionsPreAuthMax) crowd_out(pending_.begin());
}

void Acceptor::crowd_out(std::list<Pending>::iterator pending) {
  net_metrics().crowded_out.add();
  drop(pending, "too many unauthenticated connections");
}

// The peer is forgotten first, and ended from the loop's queue: whoever hears of its end may close
// this acceptor. Of a peer that was handed on, its owner tells, who knows its name.
void Acceptor::drop(std::list<Pending>::iterator pending, const char* reason) {
  const Pending dropped = std::move(*pending);
  pending_.erase(pending);
  if (dropped.handshaking) {
    log_failure(dropped.address, reason);
    asio::error_code ignored;
    dropped.handshaking->socket().close(ignored);
  } else if (const ConnectionPtr connection = dropped.connection.lock()) {
    connection->end_soon(Status::deadline_exceeded(reason));
  }
}

void Acceptor::handshake(Tcp::socket socket, const std::string& address) {
  PeerIdentity identity = identity_at_door(socket);
  auto stream =
      std::make_shared<TlsSocket>(std::move(socket), tls_->impl().ends->server.native_handle());
  pending_.push_back({address, std::chrono::steady_clock::now(), stream, {}});
  stream->handshake_as_server([self = shared_from_this(), stream,
                               identity](const asio::error_code& error) mutable {
    if (self->is_closed_) return;
    const auto pending = std::find_if(self->pending_.begin(), self->pending_.end(),
                                      [&](const Pending& p) { return p.handshaking == stream; });
    if (pending == self->pending_.end()) return;  // dropped meanwhile
    if (error) {
      const auto failure = handshake_failure(stream->ssl(), error);
      net_metrics().handshakes_failed.add();
      log_failure(identity.address, failure.text(), failure.subject);
      self->pending_.erase(pending);
      return;
    }
    if (const auto refusal = refusal_of(stream->ssl()))
      return self->refuse(pending, std::move(identity), *refusal);
    PeerIdentity proven = identity_of(stream->ssl());
    proven.address = identity.address;
    proven.port = identity.port;
    proven.rtt_seconds = identity.rtt_seconds;
    proven.is_in_reserve = identity.is_in_reserve;
    pending->handshaking.reset();
    self->hand_on(pending, make_byte_stream(stream), std::move(proven));
  });
}

// Says why, over the encrypted link, and closes. The peer takes a place among those that have not
// proven themselves until that is done.
void Acceptor::refuse(std::list<Pending>::iterator pending, PeerIdentity identity,
                      const HandshakeFailure& refusal) {
  net_metrics().handshakes_failed.add();
  log_failure(identity.address, refusal.text(), refusal.subject);
  const std::shared_ptr<TlsSocket> stream = std::move(pending->handshaking);
  const ConnectionPtr connection =
      make_connection(io_, make_byte_stream(stream), std::move(identity));
  pending->connection = connection;
  const auto& record_of = tls_->impl().refusal;
  if (record_of) connection->send(record_of("the " + refusal.text()));
  connection->close(kFarewell);
  auto farewell = std::make_shared<asio::steady_timer>(context_of(io_), kFarewell);
  farewell->async_wait([farewell, connection](const asio::error_code&) {});
}

void Acceptor::hand_on(std::list<Pending>::iterator pending, std::unique_ptr<ByteStream> stream,
                       PeerIdentity identity) {
  const ConnectionPtr connection = make_connection(io_, std::move(stream), std::move(identity));
  pending->connection = connection;
  if (tls_) tls_->impl().watch(connection);
  on_accept_(connection);
}

void Acceptor::mark_authenticated(const Connection& connection) {
  for (auto pending = pending_.begin(); pending != pending_.end(); ++pending) {
    if (pending->connection.lock().get() == &connection) {
      authenticated_.push_back(pending->connection);
      pending_.erase(pending);
      return;
    }
  }
}

void Acceptor::sweep() {
  const auto oldest = std::chrono::steady_clock::now() - std::chrono::milliseconds(kHandshakeMs);
  for (auto pending = pending_.begin(); pending != pending_.end();) {
    const auto next = std::next(pending);
    if (!pending->handshaking && pending->connection.expired()) {
      pending_.erase(pending);
    } else if (pending->since < oldest) {
      net_metrics().handshakes_failed.add();
      drop(pending, "no complete handshake in time");
    }
    pending = next;
  }
}

void Acceptor::close() {
  is_closed_ = true;
  asio::error_code ignored;
  for (Tcp::acceptor& acceptor : acceptors_) acceptor.close(ignored);
  sweep_.cancel();
  for (const Pending& pending : pending_) {
    if (pending.handshaking) pending.handshaking->socket().close(ignored);
  }
  pending_.clear();
}

class AcceptorListener final : public Listener {
 public:
  explicit AcceptorListener(std::shared_ptr<Acceptor> acceptor) : acceptor_(std::move(acceptor)) {}
  ~AcceptorListener() override { acceptor_->close(); }
  std::uint16_t port(std::size_t endpoint) const override { return acceptor_->port(endpoint); }
  void mark_authenticated(const Connection& connection) override {
    acceptor_->mark_authenticated(connection);
  }

 private:
  std::shared_ptr<Acceptor> acceptor_;
};

}  // namespace

Result<std::unique_ptr<Listener>> listen(IoThread& io, const Endpoint& endpoint,
                                         std::shared_ptr<TlsContext> tls,
                                         std::function<void(ConnectionPtr)> on_accept) {
  return listen_on_all(io, std::vector{endpoint}, std::move(tls), std::move(on_accept));
}

Result<std::unique_ptr<Listener>> listen_on_all(IoThread& io,
                                                const std::vector<Endpoint>& endpoints,
                                                std::shared_ptr<TlsContext> tls,
                                                std::function<void(ConnectionPtr)> on_accept) {
  auto acceptor = std::make_shared<Acceptor>(io, std::move(tls), std::move(on_accept));
  for (const Endpoint& endpoint : endpoints) TESSERA_RETURN_IF_ERROR(acceptor->open(endpoint));
  acceptor->start();
  return std::unique_ptr<Listener>(std::make_unique<AcceptorListener>(std::move(acceptor)));
}

}  // namespace tessera::net
