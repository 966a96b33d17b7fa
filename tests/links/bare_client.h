// SPDX-License-Identifier: Apache-2.0
// A client of a master on loopback whose bytes and whose end are the test's to choose.
//
// Threads. One owner.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <span>
#include <string>

#include "common/net/crc32c.h"
#include "common/net/record_head.h"
#include "common/wire/codec.h"
#include "common/wire/record_types.h"

namespace tessera::test {

inline std::string bytes_of(wire::Message message) {
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

inline wire::Hello hello(wire::Role role = wire::Role::kStatus) {
  wire::Hello hello;
  hello.role = role;
  hello.name = "asks";
  hello.threads = 1;  // of a slave, as are the instruction sets
  hello.isas = isa_bit(Isa::kScalar);
  hello.build_id = "by hand";
  return hello;
}

// A socket whose bytes and whose end are the test's to choose. It answers no pings, and says its
// Hello when the scheduler lets it: on a busy machine the master may have closed it for its
// silence.
class BareClient {
 public:
  // Reads at most `receive_buffer_bytes` ahead; 0: as the system likes.
  explicit BareClient(std::uint16_t port, int receive_buffer_bytes = 0,
                      wire::Role role = wire::Role::kStatus)
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
    is_welcome_ = write(bytes_of(hello(role))) && reads_welcome();
  }
  ~BareClient() { ::close(socket_); }
  BareClient(const BareClient&) = delete;
  BareClient& operator=(const BareClient&) = delete;

  bool is_welcome() const { return is_welcome_; }

  // Returns: whether the master took all of it.
  [[nodiscard]] bool write(const std::string& bytes) const {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t count = ::send(socket_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
      if (count <= 0) return false;
      done += static_cast<std::size_t>(count);
    }
    return true;
  }
  // Waits until a small write would not block: in at_once() it must not, for the master stands
  // still.
  void wait_for_room() const {
    pollfd room{socket_, POLLOUT, 0};
    ::poll(&room, 1, -1);
  }
  // Returns: whether an answer comes, with or without pings before it.
  bool hears_reply() const {
    net::RecordHead reply;
    reply.type = static_cast<std::uint16_t>(wire::RecordType::kStatusReply);
    const auto head = net::encode_head(reply);
    const std::string wanted(reinterpret_cast<const char*>(head.data()), 8);  // as far as the type
    std::string heard;
    char buffer[4096];
    while (heard.find(wanted) == std::string::npos) {
      const ssize_t count = ::recv(socket_, buffer, sizeof(buffer), 0);
      if (count <= 0) return false;
      heard.append(buffer, static_cast<std::size_t>(count));
    }
    return true;
  }
  // Returns: whether the first record that comes is a welcome.
  bool reads_welcome() const {
    net::RecordHead welcome;
    welcome.type = static_cast<std::uint16_t>(wire::RecordType::kWelcome);
    const auto head = net::encode_head(welcome);
    char buffer[4096];
    const ssize_t count = ::recv(socket_, buffer, sizeof(buffer), 0);
    return count >= 8 && std::memcmp(buffer, head.data(), 8) == 0;
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
  bool is_welcome_ = false;
};

}  // namespace tessera::test
