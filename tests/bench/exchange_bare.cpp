// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/exchange_bare.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "common/base/check.h"
#include "tests/bench/contender.h"
#include "tests/bench/exchange_slaves.h"

namespace tessera::bench {
namespace {

constexpr double kWarmUpSeconds = 1;

class BareMaster {
 public:
  BareMaster() : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    TESSERA_CHECK_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    TESSERA_CHECK_EQ(::listen(listener_, 64), 0);
  }
  ~BareMaster() {
    for (const Peer& peer : peers_) ::close(peer.file);
    ::close(epoll_);
    ::close(listener_);
  }
  BareMaster(const BareMaster&) = delete;
  BareMaster& operator=(const BareMaster&) = delete;

  std::uint16_t port() const {
    sockaddr_in address{};
    socklen_t size = sizeof(address);
    TESSERA_CHECK_EQ(::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    return ntohs(address.sin_port);
  }

  void accept(int count, int window) {
    for (int i = 0; i < count; ++i) {
      Peer& peer = peers_.emplace_back();
      peer.file = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
      const int on = 1;
      ::setsockopt(peer.file, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
      epoll_event event{};
      event.events = EPOLLIN | EPOLLET;
      event.data.ptr = &peer;
      TESSERA_CHECK_EQ(::epoll_ctl(epoll_, EPOLL_CTL_ADD, peer.file, &event), 0);
    }
    for (Peer& peer : peers_) request(peer, static_cast<std::size_t>(window));
  }

  // Returns: results taken.
  std::uint64_t run_for(double seconds) {
    const std::uint64_t before = results_;
    std::array<epoll_event, 128> events;
    for (const double end = wall_seconds() + seconds; wall_seconds() < end;) {
      const int count = ::epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), 100);
      for (int i = 0; i < count; ++i)
        take(*static_cast<Peer*>(events[static_cast<std::size_t>(i)].data.ptr));
    }
    return results_ - before;
  }

 private:
  struct Peer {
    int file = -1;
    std::size_t begun_bytes = 0;  // of the result on its way
  };

  void take(Peer& peer) {
    while (true) {
      const ssize_t got = ::recv(peer.file, buffer_.data(), buffer_.size(), 0);
      if (got <= 0) return;
      peer.begun_bytes += static_cast<std::size_t>(got);
      const std::size_t whole = peer.begun_bytes / kResultBytes;
      peer.begun_bytes %= kResultBytes;
      results_ += whole;
      request(peer, whole);
      if (static_cast<std::size_t>(got) < buffer_.size()) return;
    }
  }

  // Requests are few and small: the socket takes them.
  void request(Peer& peer, std::size_t count) {
    if (count == 0) return;
    const std::size_t bytes = std::min(count * kRequestBytes, requests_.size());
    TESSERA_CHECK_EQ(::send(peer.file, requests_.data(), bytes, MSG_NOSIGNAL),
                     static_cast<ssize_t>(bytes));
  }

  const int listener_;
  const int epoll_ = ::epoll_create1(EPOLL_CLOEXEC);
  std::deque<Peer> peers_;  // addresses stay
  std::vector<std::byte> buffer_ = std::vector<std::byte>(64 * 1024);
  std::vector<std::byte> requests_ = std::vector<std::byte>(kRequestBytes * 1024);
  std::uint64_t results_ = 0;
};

}  // namespace

ExchangeRate measure_bare_exchange(int connections, int window, double seconds) {
  ExchangePeers peers;
  peers.connections = connections;
  peers.is_bare = true;
  ExchangeProcess process(peers);
  BareMaster master;
  process.connect_to(master.port());
  master.accept(connections, window);
  master.run_for(kWarmUpSeconds);
  const double wall = wall_seconds(), cpu = thread_cpu_seconds();
  const auto results = static_cast<double>(master.run_for(seconds));
  return {results / (wall_seconds() - wall),
          1e6 * (thread_cpu_seconds() - cpu) / std::max(results, 1.0)};
}

}  // namespace tessera::bench
