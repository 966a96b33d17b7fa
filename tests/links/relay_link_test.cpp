// SPDX-License-Identifier: Apache-2.0
// A slave feeds another over real sockets, whose connections go while their own callbacks run. What
// a relay must keep is tested in virtual time (tests/unit/slave/relay_test.cpp).
#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <vector>

#include "common/net/connector.h"
#include "common/net/listener.h"
#include "slave/relay_child.h"
#include "slave/relay_feeder.h"
#include "tests/support/patience.h"

namespace tessera::slave {
namespace {

constexpr SceneVersion kVersion = 3;
constexpr std::uint32_t kChunks = 40;  // more than a send queue may hold at once
constexpr std::uint64_t kToken = 4711;

void announce(wire::SceneReceiver& receiver, const std::vector<std::byte>& block,
              wire::SceneReceiver::Actions& actions) {
  wire::SceneAnnounce announce;
  announce.version = kVersion;
  announce.digests = {make_scene_block(block).digest};
  announce.sizes = {block.size()};
  EXPECT_TRUE(receiver.announce(announce, actions).is_ok());
  EXPECT_TRUE(receiver.list({kVersion, 0, chunk_digests(block)}, actions).is_ok());
}

TEST(RelayLink, AWrongTokenIsTurnedAwayAndARightOneFed) {
  net::IoThread io("relay");
  const std::vector<std::byte> block(kChunks * kSceneChunkBytes, std::byte{7});
  wire::SceneReceiver upper, lower;
  std::unique_ptr<RelayFeeder> feeder;
  std::unique_ptr<RelayChild> child;
  std::unique_ptr<net::Listener> listener;
  std::promise<wire::RelayFault> failed;
  std::promise<void> complete;
  RelayAccess access;
  access.connect = [&io](const net::Endpoint& at, auto on_connected) {
    return net::connect(io, at, nullptr, "slave", std::chrono::milliseconds(kHandshakeMs),
                        std::move(on_connected));
  };
  const auto follow = [&](std::uint64_t token) {
    child->follow({kVersion, 9, "127.0.0.1", listener->port(), token}, lower.lacking());
  };
  io.run_and_wait([&] {
    wire::SceneReceiver::Actions actions;
    announce(upper, block, actions);
    announce(lower, block, actions);
    for (std::uint32_t i = 0; i < kChunks; ++i) {
      const std::vector<std::byte> bytes(kSceneChunkBytes, std::byte{7});
      const wire::SceneChunk chunk{kVersion, 0, std::uint64_t{i} * kSceneChunkBytes,
                                   net::SharedBytes::of(bytes)};
      EXPECT_TRUE(upper.chunk(chunk, actions).is_ok());
    }
    feeder = std::make_unique<RelayFeeder>(io, upper, kToken);
    auto made = net::listen(io, {"127.0.0.1", 0}, nullptr, [&](net::ConnectionPtr connection) {
      feeder->accept(std::move(connection), listener.get());
    });
    ASSERT_TRUE(made.is_ok());
    listener = std::move(*made);
    child = std::make_unique<RelayChild>(
        io, access,
        RelayChild::Events{[&](const wire::SceneChunk& chunk) {
                             wire::SceneReceiver::Actions done;
                             const auto verdict = lower.take(chunk, done);
                             if (!done.complete.empty()) complete.set_value();
                             return relay_fault_of(verdict);
                           },
                           [&](wire::RelayFailed fault) { failed.set_value(fault.fault); }});
    follow(kToken + 1);
  });
  auto fault = failed.get_future();
  EXPECT_EQ(fault.wait_for(test::kPatience), std::future_status::ready);
  EXPECT_EQ(fault.get(), wire::RelayFault::kGone);
  io.run_and_wait([&] { follow(kToken); });
  EXPECT_EQ(complete.get_future().wait_for(test::kPatience), std::future_status::ready);
  io.run_and_wait([&] {
    child.reset();
    listener.reset();
    feeder.reset();
  });
}

}  // namespace
}  // namespace tessera::slave
