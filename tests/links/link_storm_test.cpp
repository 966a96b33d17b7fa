// SPDX-License-Identifier: Apache-2.0
// Peers of every kind end their links at a random byte of what they say, by a reset or in order, by
// the hundred and several at once. Whoever they speak to lives and keeps nothing of them: neither
// descriptors nor memory. TESSERA_LINK_STORM=1000 visits of each of six peers is the whole storm;
// the usual one is shorter.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/net/http_page.h"
#include "common/net/listener.h"
#include "common/net/record_head.h"
#include "common/scene/scene_codec.h"
#include "common/wire/codec.h"
#include "common/wire/scene_receiver.h"
#include "master/session/master_host.h"
#include "master/session/remote_session.h"
#include "slave/relay_feeder.h"
#include "tests/links/bare_client.h"
#include "tests/support/patience.h"
#include "tests/support/seed.h"
#include "tests/support/small_scene.h"

namespace tessera::master {
namespace {

constexpr int kPeers = 6;

int visits() {
  const char* const asked = std::getenv("TESSERA_LINK_STORM");
  return asked != nullptr ? std::atoi(asked) : 40;
}

using test::bytes_of;

// One visit: a socket that says so many bytes and no more, and then ends.
class Visit {
 public:
  // Addresses of loopback take turns, since one address gets but so many connections a second.
  Visit(std::uint16_t port, std::mt19937& random, std::size_t bytes_max)
      : random_(random), left_(random() % (bytes_max + 1)) {
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const timeval patience{2, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr =
        htonl(INADDR_LOOPBACK + static_cast<std::uint32_t>(random() % 200) * 256);
    (void)::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address));
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) left_ = 0;
  }
  ~Visit() {
    const linger reset{1, 0};
    if (random_() % 3 != 0) ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &reset, sizeof(reset));
    ::close(socket_);
  }
  Visit(const Visit&) = delete;
  Visit& operator=(const Visit&) = delete;

  // Returns: false when the last byte was said that may be.
  bool say(const std::string& bytes) {
    const std::size_t count = std::min(bytes.size(), left_);
    left_ -= count;
    const ssize_t sent = ::send(socket_, bytes.data(), count, MSG_NOSIGNAL);
    return left_ > 0 && sent == static_cast<ssize_t>(bytes.size());
  }
  // Returns: the next message but Ping; nothing when the link is over.
  std::optional<wire::Message> hear() {
    while (true) {
      std::string head(net::kRecordHeadBytes, '\0');
      if (!read(head)) return std::nullopt;
      std::uint32_t sizes[2];
      std::memcpy(sizes, head.data() + 8, sizeof(sizes));
      net::ReceivedRecord record;
      std::memcpy(&record.type, head.data() + 6, sizeof(record.type));
      record.header.resize(sizes[0]);
      std::string payload(sizes[1], '\0');
      if (!read(record.header) || !read(payload)) return std::nullopt;
      const auto bytes = std::as_bytes(std::span(payload));
      record.payload.assign(bytes.begin(), bytes.end());
      auto message = wire::decode(std::move(record));
      if (!message.is_ok()) return std::nullopt;
      if (!std::holds_alternative<wire::Ping>(*message)) return std::move(*message);
    }
  }

 private:
  bool read(std::string& bytes) const {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t count = ::recv(socket_, bytes.data() + done, bytes.size() - done, 0);
      if (count <= 0) return false;
      done += static_cast<std::size_t>(count);
    }
    return true;
  }

  std::mt19937& random_;
  std::size_t left_;
  int socket_;
};

wire::Hello hello(wire::Role role, std::uint32_t number) {
  wire::Hello hello;
  hello.role = role;
  hello.name = "peer-" + std::to_string(number);
  hello.build_id = "by hand";
  if (role != wire::Role::kSlave) return hello;
  hello.threads = 1;
  hello.isas = isa_bit(Isa::kScalar);
  return hello;
}

std::size_t descriptors() {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
}

double resident_mib() {
  ::malloc_trim(0);
  std::ifstream statm("/proc/self/statm");
  double pages = 0;
  statm >> pages >> pages;
  return pages * 4096 / (1 << 20);
}

// Calls `visit` from several threads, then looks that all descriptors and the memory are back.
void storm(const std::function<void(std::mt19937&, std::uint32_t number)>& visit) {
  const auto run = [&](int times, std::uint64_t seed) {
    std::vector<std::thread> peers;
    for (int peer = 0; peer < kPeers; ++peer) {
      peers.emplace_back([&, peer] {
        std::mt19937 random(static_cast<std::uint32_t>(seed) + static_cast<std::uint32_t>(peer));
        for (int i = 0; i < times; ++i) {
          visit(random, static_cast<std::uint32_t>(random() % 1'000'000));
        }
      });
    }
    for (std::thread& peer : peers) peer.join();
  };
  const auto wait_for_descriptors = [](std::size_t wanted) {
    const TimePoint deadline = Clock::now() + test::kPatience;
    // One count decides: a peer that has ended may wait to be accepted, for a moment.
    std::size_t open = descriptors();
    while (open > wanted && Clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      open = descriptors();
    }
    return open;
  };
  const std::size_t open_before = descriptors();
  run(10, 1);  // what is made once is made now
  EXPECT_LE(wait_for_descriptors(open_before), open_before);
  [[maybe_unused]] const double before = resident_mib();
  run(visits(), test::seed(100));
  EXPECT_LE(wait_for_descriptors(open_before), open_before);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // One input buffer (64 KiB) of each visit would be 15 MiB in the usual storm.
  EXPECT_LE(resident_mib(), before + 8);
#endif
}

class LinkStorm : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { init_log(LogLevel::kOff, LogFormat::kText); }
  void start(int local_slaves) {
    SessionOptions options;
    options.local_slaves = local_slaves;
    options.local_threads = 1;
    options.listen = "127.0.0.1:0";
    options.is_plain = true;
    auto host = MasterHost::start(options, true);
    ASSERT_TRUE(host.is_ok()) << host.status().message();
    host_ = std::move(*host);
  }
  SessionOptions client_options() const {
    SessionOptions options;
    options.connect = "127.0.0.1:" + std::to_string(host_->listen_port());
    options.is_plain = true;
    return options;
  }
  std::uint16_t port() const { return host_->listen_port(); }
  void expect_alive() const {
    Status last;
    for (int i = 0; i < 20; ++i) {
      last = fetch_status(client_options()).status();
      if (last.is_ok()) return;
    }
    ADD_FAILURE() << last.message();
  }

  std::unique_ptr<MasterHost> host_;
};

TEST_F(LinkStorm, StatusClients) {
  start(0);
  const std::string request = bytes_of(wire::StatusRequest{true});
  const std::string goodbye = bytes_of(wire::Goodbye{"that is all"});
  std::atomic<int> welcome{0};
  storm([&](std::mt19937& random, std::uint32_t number) {
    Visit visit(port(), random, 700);
    if (!visit.say(bytes_of(hello(wire::Role::kStatus, number))) || !visit.hear()) return;
    ++welcome;
    for (std::uint32_t i = random() % 8; i > 0; --i) {
      if (!visit.say(request)) return;
      if (random() % 2 == 0) (void)visit.hear();
    }
    (void)visit.say(random() % 4 == 0 ? bytes_of(wire::FrameCancel{1}) + goodbye
                                      : goodbye + goodbye);
  });
  EXPECT_GE(welcome, kPeers * visits() / 4) << "most are let in";
  expect_alive();
}

TEST_F(LinkStorm, Slaves) {
  start(0);
  const std::string goodbye = bytes_of(wire::Goodbye{"that is all"});
  storm([&](std::mt19937& random, std::uint32_t number) {
    Visit tile(port(), random, 400);
    if (!tile.say(bytes_of(hello(wire::Role::kSlave, number)))) return;
    const auto answer = tile.hear();
    const auto* const welcome = answer ? std::get_if<wire::Welcome>(&*answer) : nullptr;
    if (welcome == nullptr) return;
    Visit scene(port(), random, 400);
    if (!scene.say(bytes_of(wire::Join{1, welcome->session, welcome->token})) || !scene.hear())
      return;
    Visit& first = random() % 2 == 0 ? tile : scene;
    (void)first.say(random() % 2 == 0 ? goodbye + goodbye : bytes_of(wire::FrameEnd{1}) + goodbye);
    (void)(&first == &tile ? scene : tile).say(goodbye + goodbye);
  });
  expect_alive();
}

TEST_F(LinkStorm, Applications) {
  start(0);
  const EncodedScene scene = SceneEncoder().encode(test::make_small_scene());
  wire::SceneAnnounce announce;
  announce.version = 1;
  for (const SceneBlock& block : scene.blocks) {
    announce.digests.push_back(block.digest);
    announce.sizes.push_back(block.bytes->size());
  }
  std::string words = bytes_of(announce);
  for (std::uint32_t i = 0; i < scene.blocks.size(); ++i)
    words += bytes_of(wire::SceneChunk{1, i, 0, {scene.blocks[i].bytes, *scene.blocks[i].bytes}});
  FrameSettings settings;
  settings.width_px = settings.height_px = 64;
  for (FrameId frame = 0; frame < 3; ++frame)
    words += bytes_of(wire::FrameSubmit{frame, 1, settings});
  words += bytes_of(wire::FrameCancel{1}) + bytes_of(wire::Goodbye{"that is all"}) +
           bytes_of(wire::Goodbye{"that is all"});
  storm([&](std::mt19937& random, std::uint32_t number) {
    Visit visit(port(), random, words.size() + 100);
    if (!visit.say(bytes_of(hello(wire::Role::kApp, number)))) return;
    const auto answer = visit.hear();  // one is let in, the others hear that it is
    if (!answer || !std::holds_alternative<wire::Welcome>(*answer)) return;
    (void)visit.say(words);
  });
  expect_alive();
}

// A hundred at once, again and again, while an application gets its frames.
TEST_F(LinkStorm, ManyStatusClientsAtOnceBesideAnApplication) {
  start(1);
  auto session = open_remote_session(client_options());
  ASSERT_TRUE(session.is_ok()) << session.status().message();
  ASSERT_TRUE((*session)->commit_scene(test::make_small_scene()).is_ok());
  FrameSettings settings;
  settings.width_px = settings.height_px = 32;
  settings.renderer = Renderer::kPrimary;
  std::atomic<bool> is_over{false};
  std::optional<Digest> first;
  int frames = 0;
  std::thread application([&] {
    while (!is_over || frames == 0) {
      ASSERT_TRUE((*session)->submit(settings).is_ok());
      const auto result = (*session)->next_frame(test::kPatience);
      ASSERT_TRUE(result.is_ok() && result->status.is_ok());
      if (!first) first = result->stats.digest;
      ASSERT_EQ(result->stats.digest, *first);
      ++frames;
    }
  });
  const std::size_t open_before = descriptors();
  std::atomic<int> answers{0};
  const int rounds = std::max(2, visits() / 50);
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::thread> clients;
    for (int i = 0; i < 100; ++i) {
      clients.emplace_back([&] { answers += fetch_status(client_options()).is_ok() ? 1 : 0; });
    }
    for (std::thread& client : clients) client.join();
  }
  is_over = true;
  application.join();
  // One address gets 1,024 connections at once and a hundred a second: the others are turned away.
  EXPECT_GE(answers, std::min(100 * rounds, 1000) / 4);
  EXPECT_EQ((*session)->interruption(), "");
  const TimePoint deadline = Clock::now() + test::kPatience;
  while (descriptors() > open_before && Clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_LE(descriptors(), open_before);
  expect_alive();
}

TEST(RelayStorm, Children) {
  init_log(LogLevel::kOff, LogFormat::kText);
  net::IoThread io("relay");
  wire::SceneReceiver receiver;
  std::unique_ptr<slave::RelayFeeder> feeder;
  std::unique_ptr<net::Listener> listener;
  io.run_and_wait([&] {
    feeder = std::make_unique<slave::RelayFeeder>(io, receiver, 4711);
    auto made = net::listen(io, {"127.0.0.1", 0}, nullptr, [&](net::ConnectionPtr connection) {
      feeder->accept(std::move(connection), listener.get());
    });
    ASSERT_TRUE(made.is_ok());
    listener = std::move(*made);
  });
  const std::uint16_t port = listener->port();
  storm([&](std::mt19937& random, std::uint32_t) {
    Visit visit(port, random, 200);
    const std::uint64_t token = random() % 4 == 0 ? 1 : 4711;
    if (!visit.say(bytes_of(wire::RelayJoin{token, wire::kByteCodingsAll}))) return;
    const std::string need = bytes_of(wire::SceneChunkNeed{3, 0, std::vector<bool>(40, true)});
    // The version may still be announced, so one that knows the token waits for it.
    if (visit.say(need + need) && token != 4711) (void)visit.hear();
  });
  std::size_t children = 1;
  const TimePoint deadline = Clock::now() + test::kPatience;
  while (children > 0 && Clock::now() < deadline)
    io.run_and_wait([&] { children = feeder->child_count(); });
  EXPECT_EQ(children, 0u);
  io.run_and_wait([&] {
    listener.reset();
    feeder.reset();
  });
}

TEST(MetricsStorm, Scrapers) {
  net::IoThread io("page");
  std::unique_ptr<net::HttpPage> page;
  io.run_and_wait([&] {
    auto opened = net::HttpPage::open(
        io, {"127.0.0.1", 0}, {"/metrics", "text/plain", [] { return std::string(200'000, 'x'); }});
    ASSERT_TRUE(opened.is_ok());
    page = std::move(*opened);
  });
  const std::uint16_t port = page->port();
  const std::string request = "GET /metrics HTTP/1.0\r\nHost: here\r\n\r\n";
  storm([&](std::mt19937& random, std::uint32_t) {
    Visit visit(port, random, 2 * request.size());
    if (visit.say(request) && random() % 2 == 0) (void)visit.say(request);
  });
  io.run_and_wait([&] { page.reset(); });
}

}  // namespace
}  // namespace tessera::master
