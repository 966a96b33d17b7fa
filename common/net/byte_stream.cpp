// SPDX-License-Identifier: Apache-2.0
#include "common/net/byte_stream.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <array>
#include <utility>

#include "common/net/endpoint.h"

namespace tessera::net {
namespace {

std::size_t write_some_now(int socket, const std::vector<asio::const_buffer>& buffers) {
  std::array<iovec, kGatherBuffersMax> parts;
  TESSERA_CHECK_LE(buffers.size(), parts.size());
  for (std::size_t i = 0; i < buffers.size(); ++i)
    parts[i] = {const_cast<void*>(buffers[i].data()), buffers[i].size()};
  msghdr message{};
  message.msg_iov = parts.data();
  message.msg_iovlen = buffers.size();
  const ssize_t written = ::sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL);
  return written > 0 ? static_cast<std::size_t>(written) : 0;
}

// Shuts down sending on either kind of plain socket or on the one below TLS.
template <typename Socket>
void shut_sending(Socket& socket) {
  asio::error_code ignored;
  socket.shutdown(asio::socket_base::shutdown_send, ignored);
}

template <typename Socket>
class PlainStream final : public ByteStream {
 public:
  PlainStream(Socket socket, bool needs_checksum)
      : socket_(std::move(socket)), needs_checksum_(needs_checksum) {}
  ~PlainStream() override { close(); }

  void read_some(std::span<std::byte> buffer, StreamHandler handler) override {
    socket_.async_read_some(asio::buffer(buffer.data(), buffer.size()), std::move(handler));
  }
  void write_all(const std::vector<asio::const_buffer>& buffers, StreamHandler handler) override {
    asio::async_write(socket_, buffers, std::move(handler));
  }
  std::size_t write_now(const std::vector<asio::const_buffer>& buffers) override {
    return write_some_now(socket_.native_handle(), buffers);
  }
  void shutdown_send() override { shut_sending(socket_); }
  void close() override {
    asio::error_code ignored;
    socket_.close(ignored);
  }
  bool needs_checksum() const override { return needs_checksum_; }
  LinkCounters tcp_counters() const override {
    return tcp_counters_of(const_cast<Socket&>(socket_).native_handle());
  }

 private:
  Socket socket_;
  const bool needs_checksum_;
};

class EncryptedStream final : public ByteStream {
 public:
  explicit EncryptedStream(std::shared_ptr<TlsSocket> tls) : tls_(std::move(tls)) {}
  ~EncryptedStream() override { close(); }

  void read_some(std::span<std::byte> buffer, StreamHandler handler) override {
    tls_->read_some(buffer, std::move(handler));
  }
  void write_all(const std::vector<asio::const_buffer>& buffers, StreamHandler handler) override {
    tls_->write_all(buffers, std::move(handler));
  }
  std::size_t write_now(const std::vector<asio::const_buffer>& buffers) override {
    return tls_->write_now(buffers);
  }
  void shutdown_send() override { shut_sending(tls_->socket()); }
  void close() override {
    asio::error_code ignored;
    tls_->socket().close(ignored);
  }
  bool needs_checksum() const override { return false; }
  TimePoint last_heard() const override { return tls_->last_heard(); }
  LinkCounters tcp_counters() const override {
    return tcp_counters_of(tls_->socket().native_handle());
  }

 private:
  const std::shared_ptr<TlsSocket> tls_;
};

}  // namespace

std::unique_ptr<ByteStream> make_byte_stream(TcpSocket socket) {
  return std::make_unique<PlainStream<TcpSocket>>(std::move(socket), true);
}

std::unique_ptr<ByteStream> make_byte_stream(std::shared_ptr<TlsSocket> socket) {
  return std::make_unique<EncryptedStream>(std::move(socket));
}

std::unique_ptr<ByteStream> make_byte_stream(LocalSocket socket) {
  return std::make_unique<PlainStream<LocalSocket>>(std::move(socket), false);
}

PeerIdentity address_of(const TcpSocket& socket) {
  PeerIdentity identity;
  asio::error_code error;
  const auto endpoint = socket.remote_endpoint(error);
  if (error) return identity;
  identity.port = endpoint.port();
  identity.address = Endpoint{endpoint.address().to_string(), endpoint.port()}.text();
  const auto local = socket.local_endpoint(error);
  if (!error) identity.local_host = local.address().to_string();
  tcp_info info{};
  socklen_t bytes = sizeof(info);
  const int handle = const_cast<TcpSocket&>(socket).native_handle();
  if (::getsockopt(handle, IPPROTO_TCP, TCP_INFO, &info, &bytes) == 0)
    identity.rtt_seconds = 1e-6 * info.tcpi_rtt;
  return identity;
}

}  // namespace tessera::net
