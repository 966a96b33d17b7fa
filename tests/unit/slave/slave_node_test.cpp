// SPDX-License-Identifier: Apache-2.0
// SlaveNode in virtual time against a scripted master: handshake, scenes, tiles, and every way a
// session ends. Times are exact: nothing here waits for the machine, or is late because of it.
#include "slave/slave_node.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/limits.h"
#include "common/base/log.h"
#include "tests/sim/picture.h"
#include "tests/sim/sim_workshop.h"
#include "tests/unit/slave/virtual_master.h"

namespace tessera::slave {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

class SlaveNodeTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { init_log(LogLevel::kOff, LogFormat::kText); }
  ~SlaveNodeTest() override {
    master_.network().on_process_ended(*process_, true);
    process_->end();
  }

  // `tile_time`: what a tile takes in the workshop. build_failure: what its rays meet, if it is not
  // ok.
  void start(int threads, Duration tile_time, const Status& build_failure = {}) {
    sim::WorkModel model;
    model.threads = threads;
    model.tile_seconds = [tile_time, build_failure](const FrameWork& frame, TileIndex) {
      // What the rays of a tile meet is told to its frame.
      const_cast<FrameWork&>(frame).failure.add(build_failure);
      return seconds(tile_time);
    };
    model.has_pixels = false;
    workshop_ = std::make_unique<sim::SimWorkshop>(*process_, model);
    SlaveOptions options;
    options.name = "sara";
    options.threads = threads;
    options.isas = isa_bit(Isa::kScalar);
    options.renewal = renewal_;
    node_ = std::make_unique<SlaveNode>(*process_, options, master_.factory(*process_), *workshop_);
    workshop_->set_node(node_.get());
    process_->post([this] { node_->start(); });
  }

  // Gives a scene of two triangles; scenes of different tags share one mesh. Returns: how many
  // blocks the slave lacked.
  std::size_t give_scene(SceneVersion version, int tag = 1) {
    return master_.give_scene(version, sim::scene_of_tag(tag, sim::SceneWeight::kLight));
  }

  // Longest time without a ping of the slave, from `began` to the last one.
  static Duration longest_silence(const std::vector<TimePoint>& pings, TimePoint began) {
    Duration longest{};
    for (const TimePoint ping : pings) {
      if (ping < began) continue;
      longest = std::max(longest, ping - began);
      began = ping;
    }
    return longest;
  }

  net::RenewalAccess renewal_;  // of the slave that is started next
  sim::EventQueue queue_{1};
  VirtualMaster master_{queue_};
  std::unique_ptr<sim::Process> process_ =
      std::make_unique<sim::Process>(queue_, "sara", master_.network().add_node({}));
  std::unique_ptr<sim::SimWorkshop> workshop_;
  std::unique_ptr<SlaveNode> node_;
};

TEST_F(SlaveNodeTest, SaysWhoItIs) {
  start(3, 1ms);
  master_.shake_hands();
  EXPECT_EQ(master_.hello.role, wire::Role::kSlave);
  EXPECT_EQ(master_.hello.name, "sara");
  EXPECT_EQ(master_.hello.threads, 3u);
  EXPECT_EQ(master_.hello.isas, isa_bit(Isa::kScalar));
}

TEST_F(SlaveNodeTest, AsksForACertificateWhenItIsDueAndTheMasterMakesSome) {
  bool is_due = true;
  std::vector<std::string> answers;
  renewal_.request = [&]() -> std::optional<std::vector<std::byte>> {
    if (!std::exchange(is_due, false)) return std::nullopt;
    return std::vector<std::byte>(100);
  };
  renewal_.granted = [&](std::span<const std::byte>, const std::string& reason) {
    answers.push_back(reason);
  };
  start(1, 1ms);
  master_.shake_hands();
  master_.run_for(2min);
  EXPECT_TRUE(is_due) << "this master makes none";
  master_.issues_certificates = true;
  master_.close(master_.tile);
  master_.shake_hands();
  std::size_t link = 0;
  EXPECT_EQ(master_.expect<wire::CertificateRequest>(&link).der.size(), 100u);
  EXPECT_EQ(link, master_.scene);
  master_.send(link, wire::CertificateGrant{{}, "not now"});
  master_.run_for(2min);
  EXPECT_EQ(answers, std::vector<std::string>{"not now"});
  is_due = true;
  EXPECT_EQ(master_.expect<wire::CertificateRequest>().der.size(), 100u) << "and looks again";
}

TEST_F(SlaveNodeTest, AsksOnlyForBlocksItLacks) {
  start(1, 1ms);
  master_.shake_hands();
  const std::size_t all = give_scene(1, 1);
  EXPECT_EQ(master_.built.triangle_count, 2u);
  EXPECT_EQ(give_scene(2, 1), 0u) << "equal content has equal digests";
  const std::size_t some = give_scene(3, 2);
  EXPECT_GT(some, 0u);
  EXPECT_LT(some, all);
}

TEST_F(SlaveNodeTest, RefusesADamagedBlock) {
  start(1, 1ms);
  master_.shake_hands();
  const EncodedScene encoded = sim::scene_of_tag(1, sim::SceneWeight::kLight);
  master_.announce(1, encoded);
  const wire::SceneNeed need = master_.expect<wire::SceneNeed>();
  const std::span<const std::byte> sound = *encoded.blocks[need.blocks[0]].bytes;
  std::vector<std::byte> bytes(sound.begin(), sound.end());
  bytes[0] ^= std::byte{1};
  master_.send(master_.scene, wire::SceneChunk{1, need.blocks[0], 0, net::SharedBytes::of(bytes)});
  EXPECT_EQ(master_.expect<wire::SceneFailed>().version, 1u);
  give_scene(2);  // the session goes on
}

TEST_F(SlaveNodeTest, ALeaseOfAnUnknownFrameEndsTheSession) {
  start(1, 1ms);
  master_.shake_hands();
  give_scene(1);
  master_.lease(9, 0);
  master_.expect_breach("frame 9");
  master_.shake_hands();  // and a new one begins
}

TEST_F(SlaveNodeTest, AFrameOfAnUnknownSceneEndsTheSession) {
  start(1, 1ms);
  master_.shake_hands();
  master_.begin(1, 5);
  master_.expect_breach("version 5");
}

TEST_F(SlaveNodeTest, ATileOutsideTheFrameEndsTheSession) {
  start(1, 1ms);
  master_.shake_hands();
  give_scene(1);
  master_.begin(1, 1);
  master_.lease(1, 12);
  master_.expect_breach("tile 12");
}

TEST_F(SlaveNodeTest, AMessageOnTheWrongConnectionEndsTheSession) {
  start(1, 1ms);
  master_.shake_hands();
  master_.send(master_.tile, wire::SceneRetire{1});
  master_.expect_breach("SceneRetire");
}

TEST_F(SlaveNodeTest, TilesOfARetiredSceneComeBackUnrendered) {
  start(1, 1ms);
  master_.shake_hands();
  give_scene(1);
  master_.send(master_.scene, wire::SceneRetire{2});
  give_scene(2);  // once it is built, the retirement has arrived
  master_.begin(1, 1);
  master_.lease(1, 3, 2);
  const wire::TileReturned returned = master_.expect<wire::TileReturned>();
  EXPECT_EQ(returned.tile, 3u);
  EXPECT_EQ(returned.attempt, 2u);
}

// A scene that is built as rays meet it may turn out not to fit after it was told to be ready.
TEST_F(SlaveNodeTest, WhatFailsWhenRaysMeetItIsToldOnceAndItsTilesComeBack) {
  start(1, 1ms, Status::resource_exhausted("no room for a mesh"));
  master_.shake_hands();
  give_scene(1);
  master_.begin(1, 1);
  for (TileIndex tile = 0; tile < 3; ++tile) master_.lease(1, tile);
  const wire::SceneFailed failed = master_.expect<wire::SceneFailed>();
  EXPECT_EQ(failed.version, 1u);
  EXPECT_EQ(failed.reason, "no room for a mesh");
  for (TileIndex tile = 0; tile < 3; ++tile)
    EXPECT_EQ(master_.expect<wire::TileReturned>().tile, tile);
  // A frame that was on its way is no breach; its tiles come back, too.
  master_.begin(2, 1);
  master_.lease(2, 5);
  EXPECT_EQ(master_.expect<wire::TileReturned>().tile, 5u);
  give_scene(2);  // the session goes on
}

TEST_F(SlaveNodeTest, AnEndedFrameLosesItsTiles) {
  start(1, 50ms);
  master_.shake_hands();
  give_scene(1);
  master_.begin(1, 1);
  for (TileIndex tile = 0; tile < 12; ++tile) master_.lease(1, tile);
  EXPECT_EQ(master_.expect<wire::TileResult>().tile, 0u) << "first in, first out";
  master_.begin(2, 1);
  master_.send(master_.tile, wire::FrameEnd{1});
  master_.lease(2, 0);
  // The second tile of frame 1 was in work, and ten waited. None of them comes any more.
  const TimePoint began = queue_.now();
  EXPECT_EQ(master_.expect<wire::TileResult>().frame, 2u);
  EXPECT_EQ(queue_.now() - began, 50ms) << "and nothing of them was rendered";
}

TEST_F(SlaveNodeTest, ReportsStarvedTime) {
  start(2, 10ms);
  master_.shake_hands();
  give_scene(1);
  master_.run_for(1s);  // no frame is open: nobody starves
  master_.begin(1, 1);
  master_.run_for(50ms);
  master_.lease(1, 0);
  const wire::TileResult first = master_.expect<wire::TileResult>();
  EXPECT_NEAR(first.starved_seconds, 2 * 0.050 + 0.010, 1e-9)
      << "both threads until the lease, the other one for the time of the tile";
  EXPECT_NEAR(first.seconds, 0.010, 1e-9);
  master_.send(master_.tile, wire::FrameEnd{1});
  master_.run_for(1s);
  master_.begin(2, 1);
  master_.lease(2, 0);
  EXPECT_NEAR(master_.expect<wire::TileResult>().starved_seconds, 0.010, 1e-9)
      << "between frames nobody starves";
}

TEST_F(SlaveNodeTest, EitherConnectionLostEndsBothAndItComesBack) {
  start(1, 1ms);
  master_.shake_hands();
  give_scene(1);
  for (const bool is_scene : {true, false}) {
    master_.close(is_scene ? master_.scene : master_.tile);
    EXPECT_TRUE(master_.expect_closed(is_scene ? master_.tile : master_.scene));
    master_.shake_hands();
    EXPECT_EQ(give_scene(1), 0u) << "blocks outlive the session";
  }
}

TEST_F(SlaveNodeTest, KeepsTryingWhileTheMasterIsAway) {
  master_.set_away(true);
  start(1, 1ms);
  master_.run_for(10min);
  // The longest pause is kReconnectMaxMs and half of it at most.
  EXPECT_GE(master_.attempts(), 10min / (milliseconds(kReconnectMaxMs) * 3 / 2));
  master_.set_away(false);
  const TimePoint began = queue_.now();
  master_.shake_hands();
  EXPECT_LE(queue_.now() - began, milliseconds(kReconnectMaxMs) * 3 / 2);
}

TEST_F(SlaveNodeTest, ASilentMasterIsDead) {
  start(1, 1ms);
  master_.shake_hands(20, 4);
  master_.run_for(1s);
  EXPECT_EQ(master_.network().open_ends(*process_), 2u);
  master_.set_hung(true);
  // The last byte came within the last heartbeat.
  master_.run_for(milliseconds(4 * 20 - 1));
  EXPECT_EQ(master_.network().open_ends(*process_), 2u) << "too early";
  master_.run_for(milliseconds(20 + 2));
  EXPECT_EQ(master_.network().open_ends(*process_), 0u) << "five heartbeats are over";
  master_.set_hung(false);
  EXPECT_TRUE(master_.expect_closed(master_.tile));
  master_.shake_hands();
}

TEST_F(SlaveNodeTest, HeartbeatsGoOutWhileEveryWorkerIsBusy) {
  start(1, 10s);
  master_.shake_hands(kHeartbeatMs, 4);
  give_scene(1);
  master_.begin(1, 1);
  master_.lease(1, 0);
  const TimePoint began = queue_.now();
  EXPECT_EQ(master_.expect<wire::TileResult>().tile, 0u);
  EXPECT_EQ(queue_.now() - began, 10s);
  for (const std::size_t link : {master_.tile, master_.scene}) {
    const std::vector<TimePoint>& pings = master_.pings(link);
    ASSERT_FALSE(pings.empty());
    // A timer counts whole milliseconds.
    EXPECT_LE(longest_silence(pings, began), milliseconds(kHeartbeatMs + 1)) << "link " << link;
    EXPECT_LE(queue_.now() - pings.back(), milliseconds(kHeartbeatMs + 1)) << "link " << link;
  }
}

// What time or a person mends is never final, whatever it is.
TEST_F(SlaveNodeTest, WhoIsRefusedTriesAgainWithGrowingPauses) {
  constexpr std::array kCodes = {wire::RefuseCode::kName, wire::RefuseCode::kRole,
                                 wire::RefuseCode::kIsa, wire::RefuseCode::kVersion};
  start(1, 1ms);
  const TimePoint began = queue_.now();
  for (std::size_t i = 0; queue_.now() - began < 10min; ++i) {
    std::size_t link = 0;
    (void)master_.expect<wire::Hello>(&link);
    master_.send(link, wire::Refuse{kCodes[i % kCodes.size()], "not now"});
    EXPECT_TRUE(master_.expect_closed(link));
  }
  EXPECT_GE(master_.attempts(), 10min / milliseconds(kReconnectMaxMs));
  EXPECT_LE(master_.attempts(), 10min / milliseconds(kReconnectMaxMs / 2));
  const TimePoint mended = queue_.now();
  master_.shake_hands();
  EXPECT_LE(queue_.now() - mended, milliseconds(kReconnectMaxMs) + 1s);
}

TEST_F(SlaveNodeTest, ARefusedCertificateIsTriedAgain) {
  master_.set_refused(Status::permission_denied("certificate of master 'm' has expired"));
  start(1, 1ms);
  master_.run_for(10min);
  EXPECT_GE(master_.attempts(), 10min / milliseconds(kReconnectMaxMs));
  master_.set_refused(Status::ok());
  const TimePoint mended = queue_.now();
  master_.shake_hands();
  EXPECT_LE(queue_.now() - mended, milliseconds(kReconnectMaxMs) + 1s);
}

TEST_F(SlaveNodeTest, AnotherVersionIsTriedAgainOnlyAfterTheLongestPause) {
  start(1, 1ms);
  std::size_t link = 0;
  (void)master_.expect<wire::Hello>(&link);
  master_.send(link, wire::Refuse{wire::RefuseCode::kVersion, "1 to 1, this master 2 to 3"});
  EXPECT_TRUE(master_.expect_closed(link));
  master_.run_for(milliseconds(kReconnectMaxMs - 1));
  EXPECT_EQ(master_.attempts(), 1);
  master_.run_for(2ms);
  EXPECT_EQ(master_.attempts(), 2);
}

TEST_F(SlaveNodeTest, ABusyMasterIsTriedAgain) {
  start(1, 1ms);
  std::size_t link = 0;
  (void)master_.expect<wire::Hello>(&link);
  master_.send(link, wire::Refuse{wire::RefuseCode::kFull, "no room"});
  EXPECT_TRUE(master_.expect_closed(link));
  master_.shake_hands();
}

}  // namespace
}  // namespace tessera::slave
