// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/exchange_socket.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "common/base/check.h"

namespace tessera::bench {
namespace {
constexpr std::size_t kReadBytes = 4096;  // a hundred leases
}  // namespace

BenchSocket::BenchSocket(int file) : file_(file) {
  const int on = 1;
  ::setsockopt(file_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
}

BenchSocket::BenchSocket(BenchSocket&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      ssl_(std::exchange(other.ssl_, nullptr)),
      out_(std::move(other.out_)),
      sent_(std::exchange(other.sent_, 0)) {}

BenchSocket::~BenchSocket() {
  SSL_free(ssl_);
  if (file_ >= 0) ::close(file_);
}

BenchSocket BenchSocket::connect(std::uint16_t port) {
  const int file = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  TESSERA_CHECK_EQ(::connect(file, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  return BenchSocket(file);
}

void BenchSocket::start_tls(const net::KeyPair& own, X509* ca) {
  SSL_CTX* const context = SSL_CTX_new(TLS_client_method());
  SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  TESSERA_CHECK_EQ(SSL_CTX_use_certificate(context, own.certificate.get()), 1);
  TESSERA_CHECK_EQ(SSL_CTX_use_PrivateKey(context, own.key.get()), 1);
  TESSERA_CHECK_EQ(X509_STORE_add_cert(SSL_CTX_get_cert_store(context), ca), 1);
  ssl_ = SSL_new(context);
  SSL_CTX_free(context);
  SSL_set_fd(ssl_, file_);
  TESSERA_CHECK_EQ(SSL_connect(ssl_), 1);
}

bool BenchSocket::read_into(std::vector<std::byte>& in) {
  const bool blocks = (::fcntl(file_, F_GETFL) & O_NONBLOCK) == 0;
  while (true) {
    const std::size_t before = in.size();
    in.resize(before + kReadBytes);
    const ssize_t got = ssl_ != nullptr
                            ? SSL_read(ssl_, in.data() + before, static_cast<int>(kReadBytes))
                            : ::recv(file_, in.data() + before, kReadBytes, 0);
    in.resize(before + static_cast<std::size_t>(got > 0 ? got : 0));
    if (got > 0 && (blocks || (ssl_ == nullptr && static_cast<std::size_t>(got) < kReadBytes)))
      return true;
    if (got > 0) continue;
    return ssl_ != nullptr ? SSL_get_error(ssl_, static_cast<int>(got)) == SSL_ERROR_WANT_READ
                           : got < 0 && errno == EAGAIN;
  }
}

void BenchSocket::flush() {
  while (has_rest()) {
    const std::size_t rest = out_.size() - sent_;
    const ssize_t put = ssl_ != nullptr
                            ? SSL_write(ssl_, out_.data() + sent_, static_cast<int>(rest))
                            : ::send(file_, out_.data() + sent_, rest, MSG_NOSIGNAL);
    if (put <= 0) return;  // the socket is full or closed; the next read tells
    sent_ += static_cast<std::size_t>(put);
  }
  out_.clear();
  sent_ = 0;
}

BenchLoop::BenchLoop() : epoll_(::epoll_create1(EPOLL_CLOEXEC)) { TESSERA_CHECK_GE(epoll_, 0); }
BenchLoop::~BenchLoop() { ::close(epoll_); }

void BenchLoop::add(BenchSocket& socket, std::function<void()> on_input) {
  ::fcntl(socket.file(), F_SETFL, ::fcntl(socket.file(), F_GETFL) | O_NONBLOCK);
  entries_.push_back(std::make_unique<Entry>(Entry{&socket, std::move(on_input)}));
  epoll_event event{};
  event.events = EPOLLIN | EPOLLOUT | EPOLLET;
  event.data.ptr = entries_.back().get();
  TESSERA_CHECK_EQ(::epoll_ctl(epoll_, EPOLL_CTL_ADD, socket.file(), &event), 0);
}

void BenchLoop::run_once(int timeout_ms) {
  std::array<epoll_event, 128> events;
  const int count =
      ::epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), timeout_ms);
  for (int i = 0; i < count; ++i) {
    const epoll_event& event = events[static_cast<std::size_t>(i)];
    const Entry& entry = *static_cast<const Entry*>(event.data.ptr);
    if ((event.events & EPOLLOUT) != 0 && entry.socket->has_rest()) entry.socket->flush();
    if ((event.events & (EPOLLIN | EPOLLHUP | EPOLLERR)) != 0) entry.on_input();
  }
}

}  // namespace tessera::bench
