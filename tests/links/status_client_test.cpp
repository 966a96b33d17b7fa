// SPDX-License-Identifier: Apache-2.0
// Status clients leave as they like: twice, in mid-answer, with a reset. The master lives, and answers
// whoever comes next.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "common/net/crc32c.h"
#include "common/net/record_head.h"
#include "common/wire/codec.h"
#include "master/session/master_host.h"
#include "master/session/remote_session.h"

namespace tessera::master {
namespace {

std::string bytes_of(wire::Message message) {
  const net::Record record = wire::encode(std::move(message));
  const std::span payload = record.payload.bytes;
  net::RecordHead head;
  head.type = record.type;
  head.header_bytes = static_cast<std::uint32_t>(record.header.size());
  head.payload_bytes = static_cast<std::uint32_t>(payload.size());
  head.checksum = net::crc32c(net::crc32c(0, std::as_bytes(std::span(record.header))), payload);
  const auto head_bytes = net::encode_head(head);
  std::string bytes(reinterpret_cast<const char*>(head_bytes.data()), head_bytes.size());
  bytes += record.header;
  bytes.append(reinterpret_cast<const char*>(payload.data()), payload.size());
  return bytes;
}

wire::Hello hello() {
  wire::Hello hello;
  hello.role = wire::Role::kStatus;
  hello.name = "asks";
  hello.build_id = "by hand";
  return hello;
}

// A socket whose bytes and whose end are the test's to choose.
class BareClient {
 public:
  // Reads at most `receive_buffer_bytes` ahead; 0: as the system likes.
  explicit BareClient(std::uint16_t port, int receive_buffer_bytes = 0)
      : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (receive_buffer_bytes > 0) {
      ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes,
                   sizeof(receive_buffer_bytes));
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    write(bytes_of(hello()));
    EXPECT_GT(read_some(), 0) << "Welcome";
  }
  ~BareClient() { ::close(socket_); }
  BareClient(const BareClient&) = delete;
  BareClient& operator=(const BareClient&) = delete;

  void write(const std::string& bytes) const {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t count = ::send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
      ASSERT_GT(count, 0);
      done += static_cast<std::size_t>(count);
    }
  }
  ssize_t read_some() const {
    char buffer[4096];
    return ::recv(socket_, buffer, sizeof(buffer), 0);
  }
  void read_to_end() const {
    while (read_some() > 0) {
    }
  }
  // The next close() sends RST instead of FIN.
  void will_reset() const {
    const linger at_once{1, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  }

 private:
  int socket_;
};

class StatusClientTest : public ::testing::Test {
 protected:
  void SetUp() override {
    SessionOptions options;
    options.local_slaves = 0;
    options.listen = "127.0.0.1:0";
    options.is_plain = true;
    auto host = MasterHost::start(options, false);
    ASSERT_TRUE(host.is_ok()) << host.status().message();
    host_ = std::move(*host);
  }

  // While the master's thread does something else, so that all that `what` does arrives at once.
  void at_once(const std::function<void()>& what) const { host_->io().run_and_wait(what); }

  void expect_answers() const {
    SessionOptions options;
    options.connect = "127.0.0.1:" + std::to_string(host_->listen_port());
    options.is_plain = true;
    const auto status = fetch_status(options);
    EXPECT_TRUE(status.is_ok()) << status.status().message();
  }

  std::unique_ptr<MasterHost> host_;
};

TEST_F(StatusClientTest, GoodbyeTwiceInOneRead) {
  const BareClient client(host_->listen_port());
  const std::string goodbye = bytes_of(wire::Goodbye{"enough"});
  at_once([&] { client.write(bytes_of(wire::StatusRequest{}) + goodbye + goodbye + goodbye); });
  client.read_to_end();
  expect_answers();
}

TEST_F(StatusClientTest, SomethingElseTwiceInOneRead) {
  const BareClient client(host_->listen_port());
  const std::string breach = bytes_of(wire::FrameCancel{1});
  at_once([&] { client.write(breach + breach + bytes_of(wire::Goodbye{"enough"})); });
  client.read_to_end();
  expect_answers();
}

// The answers do not fit into the socket, so that a write is under way when the goodbye comes, and it
// fails.
TEST_F(StatusClientTest, GoodbyeWhileAnAnswerCannotBeSent) {
  const BareClient bystander(host_->listen_port());
  constexpr int kLittle = 4096;
  std::optional<BareClient> client(std::in_place, host_->listen_port(), kLittle);
  // So many that their answers are more than a socket's buffers take (4 MiB by default, and ours).
  constexpr std::size_t kRequests = 200'000;
  const std::string request = bytes_of(wire::StatusRequest{});
  std::string requests;
  for (std::size_t i = 0; i < kRequests; ++i) requests += request;
  client->write(requests);
  at_once([&] {
    client->write(bytes_of(wire::Goodbye{"enough"}));
    client->will_reset();
    client.reset();
  });
  expect_answers();
  bystander.write(bytes_of(wire::StatusRequest{}));
  EXPECT_GT(bystander.read_some(), 0) << "others are still here";
}

TEST_F(StatusClientTest, ComesAndGoesManyTimes) {
  for (int i = 0; i < 200; ++i) {
    const BareClient client(host_->listen_port());
    const std::string goodbye = bytes_of(wire::Goodbye{"enough"});
    if (i % 2 == 0) client.will_reset();
    at_once([&] { client.write(bytes_of(wire::StatusRequest{}) + goodbye + goodbye); });
  }
  expect_answers();
}

}  // namespace
}  // namespace tessera::master
