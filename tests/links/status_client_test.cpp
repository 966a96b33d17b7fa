// SPDX-License-Identifier: Apache-2.0
// Status clients leave as they like: twice, in mid-answer, with a reset. The master lives, and
// answers whoever comes next.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/descriptors.h"
#include "common/base/limits.h"
#include "master/session/master_host.h"
#include "master/session/remote_session.h"
#include "tests/links/bare_client.h"

namespace tessera::master {
namespace {

using test::BareClient;
using test::bytes_of;

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

  // Calls `what` while the master's thread does something else, so that all that it sends arrives
  // at once. Returns: what `what` returns.
  bool at_once(const std::function<bool()>& what) const {
    bool result = false;
    host_->io().run_and_wait([&] { result = what(); });
    return result;
  }

  // Expects an answer. Some try may come too late on a busy machine; a master that has gone answers
  // none.
  void expect_answers() const {
    SessionOptions options;
    options.connect = "127.0.0.1:" + std::to_string(host_->listen_port());
    options.is_plain = true;
    std::string last;
    for (int i = 0; i < kTries; ++i) {
      const auto status = fetch_status(options);
      if (status.is_ok()) return;
      last = status.status().message();
    }
    ADD_FAILURE() << "no answer in " << kTries << " tries: " << last;
  }

  // Does `what` until the clients in it were in time for it.
  static void until_in_time(const std::function<bool()>& what) {
    for (int i = 0; i < kTries; ++i) {
      if (what()) return;
    }
    ADD_FAILURE() << "closed for its silence in each of " << kTries << " tries";
  }

  // Each try ends after kHandshakeMs at the latest.
  static constexpr int kTries = 20;

  std::unique_ptr<MasterHost> host_;
};

TEST_F(StatusClientTest, GoodbyeTwiceInOneRead) {
  until_in_time([&] {
    const BareClient client(host_->listen_port());
    const std::string goodbye = bytes_of(wire::Goodbye{"enough"});
    const bool is_in_time =
        client.is_welcome() && at_once([&] {
          return client.write(bytes_of(wire::StatusRequest{}) + goodbye + goodbye + goodbye);
        });
    client.read_to_end();
    return is_in_time;
  });
  expect_answers();
}

TEST_F(StatusClientTest, SomethingElseTwiceInOneRead) {
  until_in_time([&] {
    const BareClient client(host_->listen_port());
    const std::string breach = bytes_of(wire::FrameCancel{1});
    const bool is_in_time =
        client.is_welcome() &&
        at_once([&] { return client.write(breach + breach + bytes_of(wire::Goodbye{"enough"})); });
    client.read_to_end();
    return is_in_time;
  });
  expect_answers();
}

// The answers do not fit into the socket, so that a write is under way when the goodbye comes, and
// it fails.
TEST_F(StatusClientTest, GoodbyeWhileAnAnswerCannotBeSent) {
  // The answers to so many are more than a socket's buffers take (4 MiB by default, and ours).
  constexpr std::size_t kRequests = 200'000;
  const std::string request = bytes_of(wire::StatusRequest{});
  std::string requests;
  for (std::size_t i = 0; i < kRequests; ++i) requests += request;
  until_in_time([&] {
    constexpr int kLittle = 4096;
    std::optional<BareClient> client(std::in_place, host_->listen_port(), kLittle);
    if (!client->is_welcome() || !client->write(requests)) return false;
    client->wait_for_room();
    return at_once([&] {
      const bool is_in_time = client->write(bytes_of(wire::Goodbye{"enough"}));
      client->will_reset();
      client.reset();
      return is_in_time;
    });
  });
  expect_answers();
}

// A client that breaks the rules ends alone.
TEST_F(StatusClientTest, OthersStayWhenOneLeaves) {
  until_in_time([&] {
    const BareClient bystander(host_->listen_port());
    const BareClient client(host_->listen_port());
    const auto began = std::chrono::steady_clock::now();
    const bool is_in_time =
        bystander.is_welcome() && client.is_welcome() && at_once([&] {
          return client.write(bytes_of(wire::FrameCancel{1}) + bytes_of(wire::Goodbye{"enough"}));
        });
    client.read_to_end();
    const bool is_here =
        bystander.write(bytes_of(wire::StatusRequest{})) && bystander.hears_reply();
    const std::chrono::milliseconds silence(kHeartbeatMs * kHeartbeatsMissedMax);
    if (!is_in_time || (!is_here && std::chrono::steady_clock::now() - began > silence))
      return false;
    EXPECT_TRUE(is_here);
    return true;
  });
}

TEST_F(StatusClientTest, ComesAndGoesManyTimes) {
  for (int i = 0; i < 200; ++i) {
    const BareClient client(host_->listen_port());
    const std::string goodbye = bytes_of(wire::Goodbye{"enough"});
    if (i % 2 == 0) client.will_reset();
    at_once([&] { return client.write(bytes_of(wire::StatusRequest{}) + goodbye + goodbye); });
  }
  expect_answers();
}

// Descriptors are taken until the reserve is reached, by way of a lower limit. Nobody is connected
// before, who might leave a number below the reserve afterwards.
TEST_F(StatusClientTest, IsAnsweredFromTheReserveWhenOthersAreTurnedAway) {
  const int before = descriptor_limit();
  EXPECT_EQ(before, raise_descriptor_limit()) << "a master that listens has raised it";
  const auto limit_to = [](int limit) {
    rlimit limits{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limits), 0);
    limits.rlim_cur = static_cast<rlim_t>(limit);
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limits), 0);
  };
  constexpr int kLow = 400;  // of which 100 are the reserve
  std::vector<int> taken;
  limit_to(kLow);
  do {
    taken.push_back(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  } while (!is_in_reserve(taken.back(), kLow));
  EXPECT_FALSE(BareClient(host_->listen_port(), 0, wire::Role::kSlave).is_welcome());
  expect_answers();
  for (const int descriptor : taken) ::close(descriptor);
  until_in_time([&] {
    const BareClient slave(host_->listen_port(), 0, wire::Role::kSlave);
    return slave.is_welcome();
  });
  limit_to(before);
}

}  // namespace
}  // namespace tessera::master
