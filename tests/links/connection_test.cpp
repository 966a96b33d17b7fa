// SPDX-License-Identifier: Apache-2.0
// Records over local pairs and plain TCP, and what a peer that does not speak the protocol can do
// to a connection.
#include "common/net/connection.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <future>
#include <thread>

#include "common/base/limits.h"
#include "common/net/connector.h"
#include "common/net/listener.h"
#include "common/net/local_pair.h"
#include "common/net/record_head.h"
#include "tests/support/net_peer.h"

namespace tessera::net {
namespace {

using test::NetPeer;

std::vector<std::byte> bytes_of(std::size_t count, unsigned seed) {
  std::vector<std::byte> bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(i * 31 + seed);
  return bytes;
}

// Who waits for a task while another thread ends the loop goes on, and every task that was waited
// for ran or was dropped.
TEST(IoThread, WaitingWhileTheLoopEndsHangsNobody) {
  for (int round = 0; round < 200; ++round) {
    IoThread io("test-net");
    std::atomic<bool> is_over{false};
    std::atomic<int> ran{0};
    std::vector<std::thread> askers(
        8);  // the more there are, the likelier is one between two steps
    for (std::thread& asker : askers) {
      asker = std::thread([&] {
        while (!is_over) io.run_and_wait([&] { ++ran; });
        io.run_and_wait([&] { ++ran; });
      });
    }
    while (ran == 0) std::this_thread::yield();
    io.stop();
    is_over = true;
    for (std::thread& asker : askers) asker.join();
    EXPECT_FALSE(io.is_current());
  }
}

// A plain listener that hands its connections to the test, one after the other.
class Server {
 public:
  explicit Server(IoThread& io) : io_(io) {
    io_.run_and_wait([this] {
      auto listener = listen(io_, {"127.0.0.1", 0}, nullptr, [this](ConnectionPtr connection) {
        MutexLock lock(mutex_);
        accepted_.push_back(std::move(connection));
        changed_.notify_all();
      });
      ASSERT_TRUE(listener.is_ok()) << listener.status().message();
      listener_ = std::move(*listener);
    });
  }
  ~Server() {
    io_.run_and_wait([this] {
      listener_.reset();
      MutexLock lock(mutex_);
      accepted_.clear();
    });
  }
  std::uint16_t port() const { return listener_->port(); }
  ConnectionPtr accept() {
    const TimePoint deadline = Clock::now() + test::kPatience;
    MutexLock lock(mutex_);
    while (accepted_.empty()) {
      if (!changed_.wait_until(mutex_, deadline)) return nullptr;
    }
    ConnectionPtr connection = std::move(accepted_.front());
    accepted_.pop_front();
    return connection;
  }

 private:
  IoThread& io_;
  std::unique_ptr<Listener> listener_;
  Mutex mutex_;
  CondVar changed_;
  std::deque<ConnectionPtr> accepted_ TESSERA_GUARDED_BY(mutex_);
};

// A client that is not Tessera's.
class RawSocket {
 public:
  explicit RawSocket(std::uint16_t port) : file_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(file_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  }
  ~RawSocket() { ::close(file_); }
  void send(std::span<const std::byte> bytes) {
    EXPECT_EQ(::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }

 private:
  const int file_;
};

class ConnectionTest : public ::testing::Test {
 protected:
  // Returns: how a plain connection ends whose client sends `bytes` and then leaves, or stays.
  Status end_after(std::span<const std::byte> bytes, bool leaves,
                   const RecordLimits& limits = test::open_limits(1000, 1000)) {
    Server server(io_);
    auto client = std::make_unique<RawSocket>(server.port());
    NetPeer peer(io_);
    ConnectionPtr connection = server.accept();
    if (!connection) return Status::internal("nothing was accepted");
    peer.adopt(std::move(connection), limits);
    client->send(bytes);
    if (leaves) client.reset();
    const Status end = peer.wait_for_end();
    EXPECT_FALSE(peer.next_record().has_value()) << "nothing of a damaged record is used";
    return end;
  }

  IoThread io_{"test-net"}, other_io_{"test-net-2"};
};

TEST_F(ConnectionTest, RecordsArriveWholeAndInOrderOverALocalPair) {
  auto [a, b] = make_local_pair(io_, other_io_);
  NetPeer left(io_), right(other_io_);
  left.adopt(std::move(a));
  right.adopt(std::move(b));
  for (unsigned i = 0; i < 50; ++i) {
    left.send(static_cast<std::uint16_t>(1 + i % 60), std::string(i * 7, 'h'),
              bytes_of(i * 1001, i));
  }
  for (unsigned i = 0; i < 50; ++i) {
    const auto record = right.next_record();
    ASSERT_TRUE(record.has_value()) << i;
    EXPECT_EQ(record->type, 1 + i % 60);
    EXPECT_EQ(record->header, std::string(i * 7, 'h'));
    EXPECT_EQ(record->payload, bytes_of(i * 1001, i));
  }
  left.drop();
  EXPECT_EQ(right.wait_for_end().code(), StatusCode::kUnavailable);
}

TEST_F(ConnectionTest, RecordsArriveOverPlainTcpInBothDirections) {
  Server server(io_);
  NetPeer client(other_io_), peer(io_);
  std::promise<Result<ConnectionPtr>> connected;
  std::unique_ptr<ConnectAttempt> attempt;
  other_io_.run_and_wait([&] {
    attempt =
        connect(other_io_, {"127.0.0.1", server.port()}, nullptr, "master", test::kPatience,
                [&](Result<ConnectionPtr> result) { connected.set_value(std::move(result)); });
  });
  auto result = connected.get_future().get();
  ASSERT_TRUE(result.is_ok()) << result.status().message();
  client.adopt(std::move(*result));
  peer.adopt(server.accept());
  client.send(3, "there", bytes_of(1 << 20, 1));
  peer.send(4, "back", {});
  const auto there = peer.next_record(), back = client.next_record();
  ASSERT_TRUE(there && back);
  EXPECT_EQ(there->payload, bytes_of(1 << 20, 1));
  EXPECT_EQ(back->header, "back");
  io_.run_and_wait([&] { EXPECT_FALSE(peer.connection().peer().is_authenticated); });
  other_io_.run_and_wait([&] { attempt.reset(); });
}

TEST_F(ConnectionTest, OneThatIsNotThereIsUnavailable) {
  std::promise<Status> ended;
  std::unique_ptr<ConnectAttempt> attempt;
  io_.run_and_wait([&] {
    attempt = connect(io_, {"127.0.0.1", 1}, nullptr, "master", test::kPatience,
                      [&](Result<ConnectionPtr> result) { ended.set_value(result.status()); });
  });
  const Status status = ended.get_future().get();
  EXPECT_EQ(status.code(), StatusCode::kUnavailable);
  EXPECT_NE(status.message().find("127.0.0.1:1"), std::string::npos);
  io_.run_and_wait([&] { attempt.reset(); });
}

TEST_F(ConnectionTest, APortInUseIsNamed) {
  Server server(io_);
  io_.run_and_wait([&] {
    auto second = listen(io_, {"127.0.0.1", server.port()}, nullptr, [](ConnectionPtr) {});
    ASSERT_FALSE(second.is_ok());
    EXPECT_NE(second.status().message().find(std::to_string(server.port())), std::string::npos);
  });
}

TEST_F(ConnectionTest, SeveralLinksLeadToOneListener) {
  std::promise<void> both;
  std::vector<ConnectionPtr> accepted;
  std::unique_ptr<Listener> listener;
  io_.run_and_wait([&] {
    auto opened = listen_on_all(io_, {{"127.0.0.1", 0}, {"127.0.0.2", 0}}, nullptr,
                                [&](ConnectionPtr connection) {
                                  accepted.push_back(std::move(connection));
                                  if (accepted.size() == 2) both.set_value();
                                });
    ASSERT_TRUE(opened.is_ok()) << opened.status().message();
    listener = std::move(*opened);
  });
  std::vector<std::unique_ptr<ConnectAttempt>> attempts;
  io_.run_and_wait([&] {
    for (std::size_t i = 0; i < 2; ++i) {
      const std::string host = i == 0 ? "127.0.0.1" : "127.0.0.2";
      attempts.push_back(connect(io_, {host, listener->port(i)}, nullptr, "master", test::kPatience,
                                 [](const Result<ConnectionPtr>& result) {
                                   EXPECT_TRUE(result.is_ok()) << result.status().message();
                                 }));
    }
  });
  EXPECT_EQ(both.get_future().wait_for(test::kPatience), std::future_status::ready);
  io_.run_and_wait([&] {
    attempts.clear();
    accepted.clear();
    EXPECT_FALSE(listen_on_all(io_, {{"127.0.0.1", 0}, {"127.0.0.2", listener->port(1)}}, nullptr,
                               [](ConnectionPtr) {})
                     .is_ok())
        << "one that cannot be had is an error";
    listener.reset();
  });
}

TEST_F(ConnectionTest, GarbageEndsTheLink) {
  EXPECT_EQ(end_after(bytes_of(4096, 7), false).code(), StatusCode::kDataLoss);
  const std::string http = "GET / HTTP/1.1\r\nHost: master\r\n\r\n";
  EXPECT_EQ(end_after(std::as_bytes(std::span(http)), false).code(), StatusCode::kDataLoss);
}

TEST_F(ConnectionTest, ALengthAboveItsLimitEndsTheLinkBeforeMemoryIsTaken) {
  EXPECT_EQ(end_after(encode_head({5, 1001, 0, 0}), false).code(), StatusCode::kDataLoss);
  EXPECT_EQ(end_after(encode_head({5, 0, 0xffffffff, 0}), false).code(), StatusCode::kDataLoss);
}

TEST_F(ConnectionTest, AWrongChecksumEndsTheLink) {
  std::vector<std::byte> record(kRecordHeadBytes + 10);
  const auto head = encode_head({5, 4, 6, 12345});
  std::copy(head.begin(), head.end(), record.begin());
  EXPECT_EQ(end_after(record, false).code(), StatusCode::kDataLoss);
}

TEST_F(ConnectionTest, ATruncatedRecordIsNotUsed) {
  std::vector<std::byte> record(kRecordHeadBytes + 10);
  const auto head = encode_head({5, 4, 100, 0});
  std::copy(head.begin(), head.end(), record.begin());
  for (const std::size_t length : {std::size_t{1}, kRecordHeadBytes, record.size()}) {
    const StatusCode code = end_after(std::span(record).first(length), true).code();
    EXPECT_TRUE(code == StatusCode::kUnavailable || code == StatusCode::kDataLoss) << length;
  }
}

TEST_F(ConnectionTest, AReaderThatDoesNotReadIsDroppedAtTheQueuesBound) {
  auto [a, b] = make_local_pair(io_, other_io_);
  NetPeer left(io_);
  left.adopt(std::move(a), test::open_limits(1000, 8 << 20));
  other_io_.run_and_wait([&, end = b] {});  // never started: nobody reads
  for (int i = 0; i < 20; ++i) left.send(3, "", std::vector<std::byte>(8 << 20));
  EXPECT_EQ(left.wait_for_end().code(), StatusCode::kResourceExhausted);
}

TEST_F(ConnectionTest, AClientThatSaysNothingIsDroppedInTime) {
  Server server(io_);
  RawSocket client(server.port());
  NetPeer peer(io_);
  peer.adopt(server.accept());
  const TimePoint begin = Clock::now();
  EXPECT_EQ(peer.wait_for_end().code(), StatusCode::kDeadlineExceeded);
  EXPECT_GE(seconds(Clock::now() - begin), 0.9e-3 * kHandshakeMs);
}

}  // namespace
}  // namespace tessera::net
