// SPDX-License-Identifier: Apache-2.0
// On a link so slow that a record of TLS takes longer than a silent peer lives, its bytes count as
// life.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <future>
#include <thread>

#include "common/base/clock.h"
#include "common/net/connection.h"
#include "common/net/connector.h"
#include "common/net/key_store.h"
#include "common/net/listener.h"
#include "tests/support/net_peer.h"
#include "tests/support/temp_folder.h"

namespace tessera::net {
namespace {

using namespace std::chrono_literals;

// Passes one connection on. What comes from the target waits for allow() once hold() was called.
class Relay {
 public:
  explicit Relay(std::uint16_t target_port) : listening_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in here = loopback(0);
    EXPECT_EQ(::bind(listening_, reinterpret_cast<sockaddr*>(&here), sizeof(here)), 0);
    EXPECT_EQ(::listen(listening_, 1), 0);
    socklen_t size = sizeof(here);
    EXPECT_EQ(::getsockname(listening_, reinterpret_cast<sockaddr*>(&here), &size), 0);
    port_ = ntohs(here.sin_port);
    thread_ = std::thread([this, target_port] { run(target_port); });
  }
  ~Relay() {
    is_over_ = true;
    thread_.join();
    ::close(listening_);
  }
  std::uint16_t port() const { return port_; }
  void hold() {
    allowed_ = 0;
    const long until = rounds_ + 2;  // the round under way had leave for more
    while (rounds_ < until) std::this_thread::sleep_for(1ms);
  }
  void allow(long bytes) { allowed_ += bytes; }

 private:
  static constexpr long kNoLimit = 1L << 40;

  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }

  // Returns: whether the connection stands.
  bool pass(int from, int to, long most) {
    std::array<char, 65536> data;
    const long room = std::min<long>(most, data.size());
    const ssize_t bytes = ::recv(from, data.data(), static_cast<std::size_t>(room), MSG_DONTWAIT);
    if (bytes < 0) return true;
    if (from == target_) allowed_ -= bytes;
    return bytes > 0 && ::send(to, data.data(), static_cast<std::size_t>(bytes), MSG_NOSIGNAL) > 0;
  }

  void run(std::uint16_t target_port) {
    const int peer = ::accept(listening_, nullptr, nullptr);
    target_ = ::socket(AF_INET, SOCK_STREAM, 0);
    const sockaddr_in there = loopback(target_port);
    bool is_open =
        ::connect(target_, reinterpret_cast<const sockaddr*>(&there), sizeof(there)) == 0;
    for (; is_open && !is_over_; ++rounds_) {
      const long most = allowed_;
      std::array<pollfd, 2> ready{pollfd{peer, POLLIN, 0},
                                  pollfd{most > 0 ? target_ : -1, POLLIN, 0}};
      ::poll(ready.data(), ready.size(), 1);
      if (ready[0].revents != 0) is_open = pass(peer, target_, kNoLimit);
      if (is_open && ready[1].revents != 0) is_open = pass(target_, peer, most);
    }
    ::close(peer);
    ::close(target_);
  }

  const int listening_;
  int target_ = -1;
  std::uint16_t port_ = 0;
  std::atomic<long> allowed_{kNoLimit};
  std::atomic<long> rounds_{0};
  std::atomic<bool> is_over_{false};
  std::thread thread_;
};

TEST(Trickle, PartOfATlsRecordIsASignOfLife) {
  const test::TempFolder folder;
  ASSERT_TRUE(init_key_store(folder.path()).is_ok());
  for (const char* role : {"master", "slave"})
    ASSERT_TRUE(add_key(folder.path(), role, role, kNodeDays).is_ok());
  IoThread io("test-net");
  std::promise<ConnectionPtr> accepted;
  std::unique_ptr<Listener> listener;
  io.run_and_wait([&] {
    auto tls = TlsContext::load(folder / "master", "master");
    ASSERT_TRUE(tls.is_ok());
    auto made = listen(io, {"127.0.0.1", 0}, *tls,
                       [&](ConnectionPtr one) { accepted.set_value(std::move(one)); });
    ASSERT_TRUE(made.is_ok());
    listener = std::move(*made);
  });
  Relay relay(listener->port());
  std::promise<ConnectionPtr> dialled;
  std::unique_ptr<ConnectAttempt> attempt;
  io.run_and_wait([&] {
    auto tls = TlsContext::load(folder / "slave", "slave");
    ASSERT_TRUE(tls.is_ok());
    attempt = connect(io, {"127.0.0.1", relay.port()}, *tls, "master", test::kPatience,
                      [&](Result<ConnectionPtr> one) { dialled.set_value(std::move(*one)); });
  });
  test::NetPeer here(io), there(io);
  here.adopt(dialled.get_future().get());
  there.adopt(accepted.get_future().get());
  io.run_and_wait([&] { listener->mark_authenticated(there.connection()); });
  there.send(1, "all that came before", {});
  ASSERT_TRUE(here.next_record().has_value());

  relay.hold();
  there.send(2, "", std::vector<std::byte>(16'000));  // one TLS record
  TimePoint heard{};
  io.run_and_wait([&] { heard = here.connection().last_received(); });
  for (int piece = 0; piece < 10; ++piece) {  // 15,000 bytes: never enough
    relay.allow(1500);
    const TimePoint before = heard;
    const TimePoint patience = Clock::now() + test::kPatience;
    while (heard == before && Clock::now() < patience) {
      std::this_thread::sleep_for(1ms);
      io.run_and_wait([&] { heard = here.connection().last_received(); });
    }
    ASSERT_GT(heard, before) << "piece " << piece;
  }
  relay.allow(1 << 20);
  EXPECT_EQ(here.next_record()->payload.size(), 16'000u);
  io.run_and_wait([&] {
    attempt.reset();
    listener.reset();
  });
}

}  // namespace
}  // namespace tessera::net
