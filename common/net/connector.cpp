// SPDX-License-Identifier: Apache-2.0
#include "common/net/connector.h"

#include <utility>

#include "common/net/stream_connection.h"

namespace tessera::net {
namespace {

using Tcp = asio::ip::tcp;

// One attempt: resolve, TCP, TLS. Pending operations keep it alive; cancel() silences it.
class Attempt : public std::enable_shared_from_this<Attempt> {
 public:
  Attempt(IoThread& io, Endpoint endpoint, std::shared_ptr<TlsContext> tls,
          std::string expected_role, std::function<void(Result<ConnectionPtr>)> on_connected)
      : io_(io),
        endpoint_(std::move(endpoint)),
        tls_(std::move(tls)),
        expected_role_(std::move(expected_role)),
        on_connected_(std::move(on_connected)),
        resolver_(context_of(io)),
        socket_(context_of(io)),
        deadline_(context_of(io)) {}

  void start(std::chrono::milliseconds deadline);
  void cancel();

 private:
  void on_resolved(const asio::error_code& error, const Tcp::resolver::results_type& results);
  void on_tcp(const asio::error_code& error);
  void on_handshake(const asio::error_code& error);
  void finish(Result<ConnectionPtr> result);
  void fail(const std::string& reason) {
    finish(Status::unavailable("cannot connect to " + endpoint_.text() + ": " + reason));
  }

  IoThread& io_;
  const Endpoint endpoint_;
  const std::shared_ptr<TlsContext> tls_;
  const std::string expected_role_;
  std::function<void(Result<ConnectionPtr>)> on_connected_;  // null once called or cancelled
  Tcp::resolver resolver_;
  Tcp::socket socket_;
  std::shared_ptr<TlsSocket> stream_;
  PeerIdentity peer_;
  asio::steady_timer deadline_;
};

void Attempt::start(std::chrono::milliseconds deadline) {
  deadline_.expires_after(deadline);
  deadline_.async_wait([self = shared_from_this()](const asio::error_code& error) {
    if (!error && self->on_connected_) self->fail("no answer in time");
  });
  resolver_.async_resolve(
      endpoint_.host, std::to_string(endpoint_.port),
      [self = shared_from_this()](const asio::error_code& error, const auto& results) {
        if (self->on_connected_) self->on_resolved(error, results);
      });
}

void Attempt::on_resolved(const asio::error_code& error,
                          const Tcp::resolver::results_type& results) {
  if (error)
    return fail("the name '" + endpoint_.host + "' does not resolve (" + error.message() + ")");
  // The socket is opened here to learn why it cannot be (too many open files); async_connect()
  // would say "aborted".
  asio::error_code reason;
  if (!results.empty()) socket_.open(results.begin()->endpoint().protocol(), reason);
  if (reason) return fail("this process gets no socket: " + reason.message());
  asio::async_connect(
      socket_, results,
      [self = shared_from_this()](const asio::error_code& failure, const Tcp::endpoint&) {
        if (self->on_connected_) self->on_tcp(failure);
      });
}

void Attempt::on_tcp(const asio::error_code& error) {
  if (error) return fail(error.message());
  asio::error_code ignored;
  socket_.set_option(Tcp::no_delay(true), ignored);
  peer_ = address_of(socket_);
  if (!tls_) return finish(make_connection(io_, make_byte_stream(std::move(socket_)), peer_));
  stream_ =
      std::make_shared<TlsSocket>(std::move(socket_), tls_->impl().ends->client.native_handle());
  stream_->handshake_as_client([self = shared_from_this()](const asio::error_code& failure) {
    if (self->on_connected_) self->on_handshake(failure);
  });
}

void Attempt::on_handshake(const asio::error_code& error) {
  if (error) {
    const bool is_gone = error == asio::error::eof || error == asio::ssl::error::stream_truncated ||
                         error == asio::error::connection_reset;
    if (is_gone)
      return fail(
          "it closed the connection during the TLS handshake; is it a Tessera master with keys?");
    const auto failure = handshake_failure(stream_->ssl(), error);
    // A failure without a subject is not about trust: damaged bytes, a peer without TLS.
    if (failure.subject.empty()) return fail(failure.text());
    return finish(Status::permission_denied("no trust between us and " + endpoint_.text() + ": " +
                                            failure.text()));
  }
  PeerIdentity proven = identity_of(stream_->ssl());
  if (proven.role != expected_role_) {
    return finish(Status::permission_denied(endpoint_.text() + " has a certificate of role '" +
                                            proven.role + "' (" + proven.name + "), but role '" +
                                            expected_role_ + "' is needed"));
  }
  proven.address = peer_.address;
  proven.port = peer_.port;
  proven.local_host = peer_.local_host;
  const ConnectionPtr connection =
      make_connection(io_, make_byte_stream(std::move(stream_)), std::move(proven));
  tls_->impl().watch(connection);
  finish(connection);
}

void Attempt::finish(Result<ConnectionPtr> result) {
  const auto on_connected = std::exchange(on_connected_, nullptr);
  cancel();
  on_connected(std::move(result));
}

void Attempt::cancel() {
  on_connected_ = nullptr;
  deadline_.cancel();
  resolver_.cancel();
  asio::error_code ignored;
  if (socket_.is_open()) socket_.close(ignored);
  if (stream_) stream_->socket().close(ignored);
}

class AttemptHandle final : public ConnectAttempt {
 public:
  explicit AttemptHandle(std::shared_ptr<Attempt> attempt) : attempt_(std::move(attempt)) {}
  ~AttemptHandle() override { attempt_->cancel(); }

 private:
  std::shared_ptr<Attempt> attempt_;
};

}  // namespace

std::unique_ptr<ConnectAttempt> connect(IoThread& io, const Endpoint& endpoint,
                                        std::shared_ptr<TlsContext> tls, std::string expected_role,
                                        std::chrono::milliseconds deadline,
                                        std::function<void(Result<ConnectionPtr>)> on_connected) {
  auto attempt = std::make_shared<Attempt>(io, endpoint, std::move(tls), std::move(expected_role),
                                           std::move(on_connected));
  attempt->start(deadline);
  return std::make_unique<AttemptHandle>(std::move(attempt));
}

}  // namespace tessera::net
