// SPDX-License-Identifier: Apache-2.0
#include "common/net/tls_socket.h"

#include <openssl/err.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <asio/ssl/error.hpp>
#include <cerrno>
#include <cstring>
#include <utility>

#include "common/base/check.h"

namespace tessera::net {
namespace {

// Bytes that one TLS record carries. Parts are put together, so that small ones share a record.
constexpr std::size_t kRecordBytes = 16 * 1024;
// Bytes that are taken from the socket in one call, enough for several records.
constexpr std::size_t kReadAheadBytes = 64 * 1024;

int settle(BIO* bio, ssize_t result, int retry_flag) {
  BIO_clear_retry_flags(bio);
  if (result < 0 && (errno == EAGAIN || errno == EINTR))
    BIO_set_flags(bio, retry_flag | BIO_FLAGS_SHOULD_RETRY);
  return static_cast<int>(result);
}

asio::error_code reason_of(int verdict) {
  if (verdict == SSL_ERROR_ZERO_RETURN) return asio::error::eof;
  const unsigned long error = ERR_get_error();
  if (error != 0 && ERR_GET_REASON(error) != SSL_R_UNEXPECTED_EOF_WHILE_READING)
    return {static_cast<int>(error), asio::error::get_ssl_category()};
  if (verdict == SSL_ERROR_SYSCALL && errno != 0)
    return {errno, asio::error::get_system_category()};
  return asio::ssl::error::stream_truncated;
}

}  // namespace

// OpenSSL's own socket BIO writes without MSG_NOSIGNAL, so that a peer that left would end the
// process. native_handle() is asked for each time: it is -1 once the socket is closed, whose number
// may belong to another link by then.
BIO_METHOD* TlsSocket::bio_method() {
  static BIO_METHOD* const method = [] {
    BIO_METHOD* const made = BIO_meth_new(BIO_get_new_index() | BIO_TYPE_SOURCE_SINK, "tessera");
    BIO_meth_set_read(made, [](BIO* bio, char* data, int size) {
      auto* const self = static_cast<TlsSocket*>(BIO_get_data(bio));
      const ssize_t bytes =
          ::recv(self->socket_.native_handle(), data, static_cast<std::size_t>(size), MSG_DONTWAIT);
      if (bytes > 0) self->last_heard_ = Clock::now();
      return settle(bio, bytes, BIO_FLAGS_READ);
    });
    BIO_meth_set_write(made, [](BIO* bio, const char* data, int size) {
      auto* const self = static_cast<TlsSocket*>(BIO_get_data(bio));
      return settle(bio,
                    ::send(self->socket_.native_handle(), data, static_cast<std::size_t>(size),
                           MSG_DONTWAIT | MSG_NOSIGNAL),
                    BIO_FLAGS_WRITE);
    });
    BIO_meth_set_ctrl(made, [](BIO*, int command, long, void*) -> long {
      return command == BIO_CTRL_FLUSH ? 1 : 0;
    });
    return made;
  }();
  return method;
}

TlsSocket::TlsSocket(asio::ip::tcp::socket socket, SSL_CTX* context)
    : socket_(std::move(socket)), ssl_(SSL_new(context)) {
  TESSERA_CHECK(ssl_ != nullptr);
  BIO* const bio = BIO_new(bio_method());
  BIO_set_data(bio, this);
  BIO_set_init(bio, 1);
  SSL_set_bio(ssl_.get(), bio, bio);  // the session owns the BIO now
  SSL_set_mode(ssl_.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                               SSL_MODE_RELEASE_BUFFERS);
  SSL_set_read_ahead(ssl_.get(), 1);
  SSL_set_default_read_buffer_len(ssl_.get(), kReadAheadBytes);
}

TlsSocket::~TlsSocket() = default;

bool TlsSocket::wait_for_socket(int result, std::function<void(const asio::error_code&)> again,
                                asio::error_code& error) {
  const int verdict = SSL_get_error(ssl_.get(), result);
  if (verdict != SSL_ERROR_WANT_READ && verdict != SSL_ERROR_WANT_WRITE) {
    error = reason_of(verdict);
    return false;
  }
  socket_.async_wait(
      verdict == SSL_ERROR_WANT_READ ? asio::socket_base::wait_read : asio::socket_base::wait_write,
      std::move(again));
  return true;
}

void TlsSocket::handshake_as_server(std::function<void(const asio::error_code&)> handler) {
  SSL_set_accept_state(ssl_.get());
  shake(handler);
}

void TlsSocket::handshake_as_client(std::function<void(const asio::error_code&)> handler) {
  SSL_set_connect_state(ssl_.get());
  shake(handler);
}

void TlsSocket::shake(const std::function<void(const asio::error_code&)>& handler) {
  ERR_clear_error();
  const int result = SSL_do_handshake(ssl_.get());
  asio::error_code error;
  const auto again = [this, handler](const asio::error_code& failure) {
    if (failure) return handler(failure);
    shake(handler);
  };
  if (result != 1 && wait_for_socket(result, again, error)) return;
  asio::post(socket_.get_executor(), [handler, error] { handler(error); });
}

void TlsSocket::read_some(std::span<std::byte> buffer, Handler handler) {
  ERR_clear_error();
  std::size_t bytes = 0;
  int result = 1;
  while (bytes < buffer.size()) {
    const std::size_t room = std::min<std::size_t>(buffer.size() - bytes, 1u << 30);
    result = SSL_read(ssl_.get(), buffer.data() + bytes, static_cast<int>(room));
    if (result <= 0) break;
    bytes += static_cast<std::size_t>(result);
  }
  asio::error_code error;
  if (bytes == 0) {
    const auto again = [this, buffer, handler](const asio::error_code& failure) {
      if (failure) return handler(failure, 0);
      read_some(buffer, handler);
    };
    if (wait_for_socket(result, again, error)) return;
  }
  asio::post(socket_.get_executor(),
             [handler = std::move(handler), error, bytes] { handler(error, bytes); });
}

// Writes from byte `skip` of the parts on, record by record, until all is written or the socket is
// full.
std::size_t TlsSocket::write_some(const std::vector<asio::const_buffer>& parts, std::size_t skip,
                                  asio::error_code& error) {
  static thread_local std::array<std::byte, kRecordBytes> record;
  std::size_t written = 0;
  auto part = parts.begin();
  while (true) {
    while (part != parts.end() && skip >= part->size()) skip -= (part++)->size();
    if (part == parts.end()) return written;
    std::size_t filled = 0, from = skip;
    for (auto next = part; next != parts.end() && filled < record.size(); ++next) {
      const std::size_t bytes = std::min(next->size() - from, record.size() - filled);
      std::memcpy(record.data() + filled, static_cast<const std::byte*>(next->data()) + from,
                  bytes);
      filled += bytes;
      from = 0;
    }
    ERR_clear_error();
    const int result = SSL_write(ssl_.get(), record.data(), static_cast<int>(filled));
    if (result <= 0) {
      const int verdict = SSL_get_error(ssl_.get(), result);
      if (verdict != SSL_ERROR_WANT_READ && verdict != SSL_ERROR_WANT_WRITE)
        error = reason_of(verdict);
      return written;
    }
    written += static_cast<std::size_t>(result);
    skip += static_cast<std::size_t>(result);
  }
}

std::size_t TlsSocket::write_now(const std::vector<asio::const_buffer>& parts) {
  asio::error_code ignored;
  return write_some(parts, 0, ignored);
}

void TlsSocket::write_all(std::vector<asio::const_buffer> parts, Handler handler) {
  write_rest(std::make_shared<std::vector<asio::const_buffer>>(std::move(parts)), 0, handler);
}

void TlsSocket::write_rest(const std::shared_ptr<std::vector<asio::const_buffer>>& parts,
                           std::size_t written, const Handler& handler) {
  asio::error_code error;
  written += write_some(*parts, written, error);
  if (error || written == asio::buffer_size(*parts)) {
    asio::post(socket_.get_executor(), [handler, error, written] { handler(error, written); });
    return;
  }
  socket_.async_wait(asio::socket_base::wait_write,
                     [this, parts, written, handler](const asio::error_code& failure) {
                       if (failure) return handler(failure, written);
                       write_rest(parts, written, handler);
                     });
}

}  // namespace tessera::net
