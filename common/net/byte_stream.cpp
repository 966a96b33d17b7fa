#include "common/net/byte_stream.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <utility>

namespace tessera::net {
namespace {

TcpSocket& lowest(TcpSocket& socket) { return socket; }
LocalSocket& lowest(LocalSocket& socket) { return socket; }
TcpSocket& lowest(TlsStream& stream) { return stream.next_layer(); }

template <typename Stream>
class StreamOf final : public ByteStream {
 public:
  StreamOf(std::unique_ptr<Stream> stream, bool needs_checksum)
      : stream_(std::move(stream)), needs_checksum_(needs_checksum) {}
  ~StreamOf() override { close(); }

  void read_some(std::span<std::byte> buffer, StreamHandler handler) override {
    stream_->async_read_some(asio::buffer(buffer.data(), buffer.size()), std::move(handler));
  }
  void read_all(std::span<std::byte> buffer, StreamHandler handler) override {
    asio::async_read(*stream_, asio::buffer(buffer.data(), buffer.size()), std::move(handler));
  }
  void write_all(const std::vector<asio::const_buffer>& buffers, StreamHandler handler) override {
    asio::async_write(*stream_, buffers, std::move(handler));
  }
  void shutdown_send() override {
    asio::error_code ignored;
    lowest(*stream_).shutdown(asio::socket_base::shutdown_send, ignored);
  }
  void close() override {
    asio::error_code ignored;
    lowest(*stream_).close(ignored);
  }
  bool needs_checksum() const override { return needs_checksum_; }
  LinkCounters tcp_counters() const override {
    return tcp_counters_of(lowest(*stream_).native_handle());
  }

 private:
  std::unique_ptr<Stream> stream_;
  const bool needs_checksum_;
};

}  // namespace

std::unique_ptr<ByteStream> make_byte_stream(TcpSocket socket) {
  return std::make_unique<StreamOf<TcpSocket>>(std::make_unique<TcpSocket>(std::move(socket)),
                                               true);
}

std::unique_ptr<ByteStream> make_byte_stream(std::unique_ptr<TlsStream> stream) {
  return std::make_unique<StreamOf<TlsStream>>(std::move(stream), false);
}

std::unique_ptr<ByteStream> make_byte_stream(LocalSocket socket) {
  return std::make_unique<StreamOf<LocalSocket>>(std::make_unique<LocalSocket>(std::move(socket)),
                                                 false);
}

PeerIdentity address_of(const TcpSocket& socket) {
  PeerIdentity identity;
  asio::error_code error;
  const auto endpoint = socket.remote_endpoint(error);
  if (error) return identity;
  identity.port = endpoint.port();
  identity.address = Endpoint{endpoint.address().to_string(), endpoint.port()}.text();
  tcp_info info{};
  socklen_t bytes = sizeof(info);
  const int handle = const_cast<TcpSocket&>(socket).native_handle();
  if (::getsockopt(handle, IPPROTO_TCP, TCP_INFO, &info, &bytes) == 0)
    identity.rtt_seconds = 1e-6 * info.tcpi_rtt;
  return identity;
}

std::pair<ConnectionPtr, ConnectionPtr> make_local_pair(IoThread& a, IoThread& b) {
  int ends[2] = {-1, -1};
  TESSERA_CHECK_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
  const int buffer_bytes = 1 << 20;  // one large tile; fewer wake-ups
  for (const int end : ends) {
    ::setsockopt(end, SOL_SOCKET, SO_SNDBUF, &buffer_bytes, sizeof(buffer_bytes));
  }
  PeerIdentity peer;
  peer.address = "local";
  const asio::local::stream_protocol protocol;
  return {
      make_connection(a, make_byte_stream(LocalSocket(context_of(a), protocol, ends[0])), peer),
      make_connection(b, make_byte_stream(LocalSocket(context_of(b), protocol, ends[1])), peer)};
}

}  // namespace tessera::net
