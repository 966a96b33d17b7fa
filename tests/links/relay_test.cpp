// SPDX-License-Identifier: Apache-2.0
// A slave feeds another over a real link, chunk by chunk while its own are still coming. A slave
// that lies, knocks without the token or asks for what nobody announced is found out.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

#include "common/base/clock.h"
#include "common/net/connector.h"
#include "common/net/endpoint.h"
#include "common/net/local_pair.h"
#include "common/wire/codec.h"
#include "common/wire/record_types.h"
#include "slave/relay_child.h"
#include "slave/relay_feeder.h"
#include "tests/support/patience.h"

namespace tessera::slave {
namespace {

using wire::SceneReceiver;
using Bytes = std::vector<std::byte>;
constexpr std::uint64_t kToken = 4711;
constexpr SceneVersion kVersion = 3;
constexpr std::uint32_t kChunks = 6;
constexpr auto kRelayJoin = static_cast<std::uint16_t>(wire::RecordType::kRelayJoin);

Bytes noise() {
  std::mt19937 random(5);
  Bytes bytes(kChunks * kSceneChunkBytes - 77);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random());
  return bytes;
}

wire::SceneChunk chunk_of(const Bytes& block, std::uint32_t index,
                          SceneVersion version = kVersion) {
  const auto begin = block.begin() + static_cast<std::ptrdiff_t>(index * kSceneChunkBytes);
  return {version, 0, std::uint64_t{index} * kSceneChunkBytes,
          net::SharedBytes::of(
              {begin, begin + static_cast<std::ptrdiff_t>(chunk_bytes(block.size(), index))})};
}

// Two slaves' worth of scene pipeline on one io thread. Everything but wait_for() happens there.
class RelayTest : public testing::Test {
 protected:
  RelayTest() : io_("relay") {
    access_.connect = [this](const net::Endpoint&,
                             std::function<void(Result<net::ConnectionPtr>)> on_connected) {
      ++connects_;
      auto [ours, theirs] = net::make_local_pair(io_, io_);
      if (feeder_) {
        feeder_->accept(std::move(theirs), nullptr);
      } else {
        liar_ = std::move(theirs);
        net::ConnectionCallbacks callbacks;
        callbacks.on_record = [this](net::ReceivedRecord record) {
          if (record.type != kRelayJoin) liar_->send(wire::encode(lie_));  // whatever it asks for
        };
        callbacks.on_closed = [](const Status&) {};
        net::RecordLimits limits = wire::session_limits();
        limits[kRelayJoin] = wire::relay_join_limits()[kRelayJoin];
        liar_->start(std::move(callbacks), limits);
      }
      on_connected(std::move(ours));
      return std::unique_ptr<net::ConnectAttempt>();
    };
    io_.run_and_wait([this] {
      announce(upper_);
      announce(lower_);
      feeder_ = std::make_unique<RelayFeeder>(io_, upper_, kToken);
      child_ = std::make_unique<RelayChild>(
          io_, access_,
          RelayChild::Events{
              [this](const wire::SceneChunk& chunk) {
                SceneReceiver::Actions actions;
                const auto verdict = lower_.take(chunk, actions);
                stored_ += verdict == SceneReceiver::Verdict::kStored;
                if (!actions.complete.empty()) is_complete_ = true;
                return verdict == SceneReceiver::Verdict::kStored;
              },
              [this](wire::RelayFailed failed) { fault_ = static_cast<int>(failed.fault); }});
    });
  }
  ~RelayTest() override {
    io_.run_and_wait([this] {
      child_.reset();
      feeder_.reset();
      liar_.reset();
    });
  }

  void announce(SceneReceiver& receiver) { announce(receiver, kVersion, block_); }
  void announce(SceneReceiver& receiver, SceneVersion version, const Bytes& block) {
    SceneReceiver::Actions actions;
    wire::SceneAnnounce announce;
    announce.version = version;
    announce.digests = {make_scene_block(block).digest};
    announce.sizes = {block.size()};
    EXPECT_TRUE(receiver.announce(announce, actions).is_ok());
    EXPECT_TRUE(receiver.list({version, 0, chunk_digests(block)}, actions).is_ok());
    pass_on(receiver, actions);
  }
  void pass_on(const SceneReceiver& receiver, const SceneReceiver::Actions& actions) {
    if (&receiver != &upper_ || !feeder_) return;
    for (const auto& arrival : actions.arrived) feeder_->on_arrived(arrival);
  }
  // A chunk comes to the upper slave from its master.
  void arrive(std::uint32_t index) {
    io_.run_and_wait([this, index] {
      SceneReceiver::Actions actions;
      EXPECT_TRUE(upper_.chunk(chunk_of(block_, index), actions).is_ok());
      pass_on(upper_, actions);
    });
  }
  void follow(std::uint64_t token) {
    io_.run_and_wait([this, token] {
      child_->follow({kVersion, 9, "10.0.0.1", 1, token}, lower_.lacking());
    });
  }
  template <typename Condition>
  bool wait_for(Condition condition) {
    const TimePoint deadline = Clock::now() + test::kPatience;
    while (!condition() && Clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return condition();
  }

  const Bytes block_ = noise();
  net::IoThread io_;
  RelayAccess access_;
  SceneReceiver upper_, lower_;
  std::unique_ptr<RelayFeeder> feeder_;
  std::unique_ptr<RelayChild> child_;
  net::ConnectionPtr liar_;
  wire::SceneChunk lie_;
  std::atomic<int> stored_{0}, fault_{-1};
  std::atomic<bool> is_complete_{false};
  std::atomic<int> connects_{0};
};

TEST_F(RelayTest, ChunksArePassedOnWhileOthersAreStillComing) {
  arrive(2);
  follow(kToken);
  EXPECT_TRUE(wait_for([this] { return stored_ == 1; })) << "what was there";
  arrive(5);
  EXPECT_TRUE(wait_for([this] { return stored_ == 2; })) << "as soon as it is there";
  for (const std::uint32_t i : {0u, 1u, 3u, 4u}) arrive(i);
  EXPECT_TRUE(wait_for([this] { return is_complete_.load(); }));
  EXPECT_EQ(fault_, -1);
}

// The next version is asked for before its announcement is at the feeder, which has most of it
// already; the connection of the first serves.
TEST_F(RelayTest, TheNextVersionComesOverTheSameConnectionHoweverEarlyItIsAskedFor) {
  follow(kToken);
  for (std::uint32_t i = 0; i < kChunks; ++i) arrive(i);
  ASSERT_TRUE(wait_for([this] { return is_complete_.load(); }));
  Bytes next = block_;
  next[0] ^= std::byte{1};  // its other chunks are known above; below all are asked for
  io_.run_and_wait([&] {
    is_complete_ = false;
    child_->rest();
    lower_ = SceneReceiver();
    announce(lower_, kVersion + 1, next);
    child_->follow({kVersion + 1, 9, "10.0.0.1", 1, kToken}, lower_.lacking());
  });
  stored_ = 0;
  io_.run_and_wait([&] { announce(upper_, kVersion + 1, next); });
  EXPECT_TRUE(wait_for([this] { return stored_ == kChunks - 1; })) << "what was known above";
  io_.run_and_wait([&] {
    SceneReceiver::Actions actions;
    EXPECT_TRUE(upper_.chunk(chunk_of(next, 0, kVersion + 1), actions).is_ok());
    pass_on(upper_, actions);
  });
  EXPECT_TRUE(wait_for([this] { return is_complete_.load(); }));
  EXPECT_EQ(fault_, -1);
  EXPECT_EQ(connects_, 1);
}

TEST_F(RelayTest, WhoGoesWhileNothingIsWantedIsNoFault) {
  follow(kToken);
  for (std::uint32_t i = 0; i < kChunks; ++i) arrive(i);
  ASSERT_TRUE(wait_for([this] { return is_complete_.load(); }));
  io_.run_and_wait([this] {
    child_->rest();
    feeder_->drop_all();
  });
  io_.run_and_wait([] {});
  EXPECT_EQ(fault_, -1);
}

TEST_F(RelayTest, AWrongTokenIsTurnedAway) {
  arrive(0);
  follow(kToken + 1);
  EXPECT_TRUE(wait_for([this] { return fault_ == static_cast<int>(wire::RelayFault::kGone); }));
  EXPECT_EQ(stored_, 0);
}

TEST_F(RelayTest, AVersionThatIsNotKeptIsRefused) {
  io_.run_and_wait([this] {
    child_->follow({kVersion, 9, "10.0.0.1", 1, kToken}, {{kVersion - 1, 0, {true}}});
  });
  EXPECT_TRUE(wait_for([this] { return fault_ == static_cast<int>(wire::RelayFault::kGone); }));
}

TEST_F(RelayTest, AnAlteredChunkEndsItWithThatReason) {
  Bytes altered = block_;
  altered[100] ^= std::byte{1};
  io_.run_and_wait([&] {
    feeder_.reset();
    lie_ = chunk_of(altered, 0);
  });
  follow(kToken);
  EXPECT_TRUE(wait_for([this] { return fault_ == static_cast<int>(wire::RelayFault::kAltered); }));
  EXPECT_EQ(stored_, 0);
}

TEST_F(RelayTest, OneThatGoesAwayIsReported) {
  follow(kToken);
  arrive(0);
  EXPECT_TRUE(wait_for([this] { return stored_ == 1; }));
  io_.run_and_wait([this] { feeder_->drop_all(); });
  EXPECT_TRUE(wait_for([this] { return fault_ == static_cast<int>(wire::RelayFault::kGone); }));
}

}  // namespace
}  // namespace tessera::slave
