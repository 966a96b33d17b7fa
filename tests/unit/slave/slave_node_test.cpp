// SlaveNode in its host against a scripted master: handshake, scene, tiles, and every way a session ends.
#include "slave/slave_host.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <set>

#include "common/base/limits.h"
#include "common/frame/tile_grid.h"
#include "common/scene/scene_codec.h"
#include "tests/unit/slave/fake_master.h"

namespace tessera::slave {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;

Scene one_triangle(float size) {
  auto mesh = std::make_shared<Mesh>();
  mesh->positions = {{-size, -size, 0}, {size, -size, 0}, {0, size, 0}};
  mesh->triangles = {{0, 1, 2}};
  mesh->materials = {0};
  Scene scene;
  scene.meshes.push_back(std::move(mesh));
  scene.materials.emplace_back();
  scene.instances.emplace_back();
  return scene;
}

class SlaveNodeTest : public testing::Test {
 protected:
  void start(int threads, int tile_sleep_ms) {
    SlaveOptions options;
    options.name = "sara";
    options.threads = threads;
    options.isas = isa_bit(Isa::kScalar);
    options.hooks.tile_sleep_ms = tile_sleep_ms;
    node_ = std::make_unique<SlaveHost>(master_.slave_io(), options, master_.factory());
    node_->start([this](Status status) {
      MutexLock lock(fatal_mutex_);
      fatal_ = std::move(status);
    });
  }

  void join(std::uint32_t heartbeat_ms = 250) {
    std::tie(tile_, scene_) = master_.shake_hands(heartbeat_ms);
  }

  void announce(SceneVersion version, const EncodedScene& encoded) {
    wire::SceneAnnounce announce;
    announce.version = version;
    for (const SceneBlock& block : encoded.blocks) {
      announce.digests.push_back(block.digest);
      announce.sizes.push_back(block.bytes->size());
    }
    master_.send(scene_, std::move(announce));
  }

  void send_blocks(SceneVersion version, const EncodedScene& encoded,
                   const std::vector<std::uint32_t>& blocks) {
    for (const std::uint32_t block : blocks) {
      master_.send(scene_, wire::SceneChunk{version, block, 0,
                                            net::SharedBytes::of(*encoded.blocks.at(block).bytes)});
    }
  }

  // The whole scene pipeline. Returns: how many blocks the slave lacked.
  std::size_t give_scene(SceneVersion version, float size = 1) {
    const EncodedScene encoded = SceneEncoder().encode(one_triangle(size));
    announce(version, encoded);
    const wire::SceneNeed need = master_.expect<wire::SceneNeed>();
    EXPECT_EQ(need.version, version);
    send_blocks(version, encoded, need.blocks);
    const wire::SceneBuilt built = master_.expect<wire::SceneBuilt>();
    EXPECT_EQ(built.version, version);
    EXPECT_EQ(built.triangle_count, 1u);
    return need.blocks.size();
  }

  static FrameSettings small_frame() {
    FrameSettings settings;
    settings.width_px = 64;
    settings.height_px = 40;
    settings.tile_edge_px = 16;  // 4 x 3 tiles, the last row 8 high
    settings.renderer = Renderer::kPrimary;
    return settings;
  }

  void begin(FrameId frame, SceneVersion version) {
    master_.send(tile_, wire::FrameBegin{frame, version, Isa::kScalar, small_frame()});
  }

  void expect_breach(const std::string& word) {
    bool is_told = false;
    while (const auto event = master_.next()) {
      if (!event->message) break;
      if (const auto* refuse = std::get_if<wire::Refuse>(&*event->message)) {
        is_told = true;
        EXPECT_EQ(refuse->code, wire::RefuseCode::kProtocol);
        EXPECT_NE(refuse->reason.find(word), std::string::npos) << refuse->reason;
      }
    }
    EXPECT_TRUE(is_told);
  }

  Status fatal() {
    MutexLock lock(fatal_mutex_);
    return fatal_;
  }

  FakeMaster master_;
  std::unique_ptr<SlaveHost> node_;  // goes before the master
  std::size_t tile_ = 0, scene_ = 0;
  Mutex fatal_mutex_;
  Status fatal_ TESSERA_GUARDED_BY(fatal_mutex_);
};

TEST_F(SlaveNodeTest, SaysWhoItIs) {
  start(3, 1);
  join();
  EXPECT_EQ(master_.hello().role, wire::Role::kSlave);
  EXPECT_EQ(master_.hello().name, "sara");
  EXPECT_EQ(master_.hello().threads, 3u);
  EXPECT_EQ(master_.hello().isas, isa_bit(Isa::kScalar));
}

TEST_F(SlaveNodeTest, RendersEachLeasedTileOnce) {
  start(2, 0);
  join();
  EXPECT_GT(give_scene(1), 0u);
  begin(7, 1);
  const TileGrid grid(64, 40, 16);
  for (TileIndex tile = 0; tile < grid.tile_count(); ++tile) {
    master_.send(tile_, wire::TileLease{7, tile, tile + 1});
  }
  std::set<TileIndex> seen;
  bool is_something_hit = false;
  for (TileIndex i = 0; i < grid.tile_count(); ++i) {
    const wire::TileResult result = master_.expect<wire::TileResult>();
    EXPECT_TRUE(seen.insert(result.tile).second);
    EXPECT_EQ(result.frame, 7u);
    EXPECT_EQ(result.version, 1u);
    EXPECT_EQ(result.attempt, result.tile + 1);
    EXPECT_EQ(result.pixels.size(),
              static_cast<std::size_t>(grid.rect(result.tile).pixel_count()) * 12);
    EXPECT_EQ(result.rays.primary,
              static_cast<std::uint64_t>(grid.rect(result.tile).pixel_count()));
    for (const std::byte b : result.pixels)
      is_something_hit = is_something_hit || b != std::byte{0};
  }
  EXPECT_TRUE(is_something_hit);
}

TEST_F(SlaveNodeTest, AsksOnlyForBlocksItLacks) {
  start(1, 1);
  join();
  const std::size_t all = give_scene(1, 1.0f);
  EXPECT_EQ(give_scene(2, 1.0f), 0u) << "equal content has equal digests";
  EXPECT_LT(give_scene(3, 2.0f), all + 1);
}

TEST_F(SlaveNodeTest, RefusesADamagedBlock) {
  start(1, 1);
  join();
  const EncodedScene encoded = SceneEncoder().encode(one_triangle(1));
  announce(1, encoded);
  const wire::SceneNeed need = master_.expect<wire::SceneNeed>();
  std::vector<std::byte> bytes = *encoded.blocks[need.blocks[0]].bytes;
  bytes[0] ^= std::byte{1};
  master_.send(scene_, wire::SceneChunk{1, need.blocks[0], 0, net::SharedBytes::of(bytes)});
  EXPECT_EQ(master_.expect<wire::SceneFailed>().version, 1u);
  give_scene(2);  // the session goes on
}

TEST_F(SlaveNodeTest, ALeaseOfAnUnknownFrameEndsTheSession) {
  start(1, 1);
  join();
  give_scene(1);
  master_.send(tile_, wire::TileLease{9, 0, 1});
  expect_breach("frame 9");
  join();  // and a new one begins
}

TEST_F(SlaveNodeTest, AFrameOfAnUnknownSceneEndsTheSession) {
  start(1, 1);
  join();
  begin(1, 5);
  expect_breach("version 5");
}

TEST_F(SlaveNodeTest, ATileOutsideTheFrameEndsTheSession) {
  start(1, 1);
  join();
  give_scene(1);
  begin(1, 1);
  master_.send(tile_, wire::TileLease{1, 12, 1});
  expect_breach("tile 12");
}

TEST_F(SlaveNodeTest, AMessageOnTheWrongConnectionEndsTheSession) {
  start(1, 1);
  join();
  master_.send(tile_, wire::SceneRetire{1});
  expect_breach("SceneRetire");
}

TEST_F(SlaveNodeTest, TilesOfARetiredSceneComeBackUnrendered) {
  start(1, 1);
  join();
  give_scene(1);
  master_.send(scene_, wire::SceneRetire{2});
  give_scene(2);  // so the retirement has arrived
  begin(1, 1);
  master_.send(tile_, wire::TileLease{1, 3, 2});
  const wire::TileReturned returned = master_.expect<wire::TileReturned>();
  EXPECT_EQ(returned.tile, 3u);
  EXPECT_EQ(returned.attempt, 2u);
}

TEST_F(SlaveNodeTest, AnEndedFrameLosesItsTiles) {
  start(1, 50);
  join();
  give_scene(1);
  begin(1, 1);
  for (TileIndex tile = 0; tile < 12; ++tile) master_.send(tile_, wire::TileLease{1, tile, 1});
  EXPECT_EQ(master_.expect<wire::TileResult>().tile, 0u) << "first in, first out";
  begin(2, 1);
  master_.send(tile_, wire::FrameEnd{1});
  master_.send(tile_, wire::TileLease{2, 0, 1});
  // At most what was under way when the end was sent still comes of frame 1.
  int stragglers = 0;
  wire::TileResult result = master_.expect<wire::TileResult>();
  for (; result.frame == 1 && stragglers < 12; ++stragglers) {
    result = master_.expect<wire::TileResult>();
  }
  EXPECT_EQ(result.frame, 2u);
  EXPECT_LT(stragglers, 11);
}

TEST_F(SlaveNodeTest, ReportsStarvedTime) {
  start(1, 1);
  join();
  give_scene(1);
  begin(1, 1);
  std::this_thread::sleep_for(50ms);
  master_.send(tile_, wire::TileLease{1, 0, 1});
  const wire::TileResult result = master_.expect<wire::TileResult>();
  EXPECT_GE(result.starved_seconds, 0.045);
  EXPECT_GE(result.seconds, 0.001);
}

TEST_F(SlaveNodeTest, EitherConnectionLostEndsBothAndItComesBack) {
  start(1, 1);
  join();
  give_scene(1);
  for (const bool is_scene : {true, false}) {
    master_.close(is_scene ? scene_ : tile_);
    EXPECT_TRUE(master_.expect_closed(is_scene ? tile_ : scene_));
    join();
    EXPECT_EQ(give_scene(1), 0u) << "blocks outlive the session";
  }
}

TEST_F(SlaveNodeTest, KeepsTryingWhileTheMasterIsAway) {
  master_.set_away(true);
  start(1, 1);
  while (master_.attempts() < 3) std::this_thread::sleep_for(5ms);
  master_.set_away(false);
  join();
  EXPECT_TRUE(fatal().is_ok());
}

TEST_F(SlaveNodeTest, ASilentMasterIsDead) {
  start(1, 1);
  join(20);
  // Pings are answered with pongs, so a silent master must be one that does not read: close
  // nothing, but stop the fake's thread for longer than 20 ms * 5.
  const auto began = Clock::now();
  master_.stall(400ms);
  EXPECT_TRUE(master_.expect_closed(tile_));
  EXPECT_GE(Clock::now() - began, 100ms);
}

TEST_F(SlaveNodeTest, HeartbeatsGoOutWhileEveryWorkerIsBusy) {
  start(1, 500);
  join(20);
  give_scene(1);
  begin(1, 1);
  master_.send(tile_, wire::TileLease{1, 0, 1});
  const int pings = master_.pings();
  EXPECT_EQ(master_.expect<wire::TileResult>().tile, 0u);
  EXPECT_GE(master_.pings() - pings, 4) << "on two connections in 500 ms, every 20 ms";
}

TEST_F(SlaveNodeTest, ARefusedNameIsFatalAtFirst) {
  start(1, 1);
  std::size_t link = 0;
  (void)master_.expect<wire::Hello>(&link);
  master_.send(link, wire::Refuse{wire::RefuseCode::kName, "sara is here already"});
  EXPECT_TRUE(master_.expect_closed(link));
  while (fatal().is_ok()) std::this_thread::sleep_for(1ms);
  EXPECT_NE(fatal().message().find("--name"), std::string::npos);
  EXPECT_NE(fatal().message().find("sara is here already"), std::string::npos);
  EXPECT_EQ(master_.attempts(), 1);
}

TEST_F(SlaveNodeTest, AnotherVersionIsTriedAgainOnlyAfterTheLongestPause) {
  start(1, 1);
  std::size_t link = 0;
  (void)master_.expect<wire::Hello>(&link);
  master_.send(link, wire::Refuse{wire::RefuseCode::kVersion, "1 to 1, this master 2 to 3"});
  EXPECT_TRUE(master_.expect_closed(link));
  std::this_thread::sleep_for(milliseconds(3 * kReconnectFirstMs));
  EXPECT_EQ(master_.attempts(), 1);
  EXPECT_TRUE(fatal().is_ok());
}

TEST_F(SlaveNodeTest, ABusyMasterIsTriedAgain) {
  start(1, 1);
  std::size_t link = 0;
  (void)master_.expect<wire::Hello>(&link);
  master_.send(link, wire::Refuse{wire::RefuseCode::kFull, "no room"});
  EXPECT_TRUE(master_.expect_closed(link));
  join();
  EXPECT_TRUE(fatal().is_ok());
}

TEST_F(SlaveNodeTest, StoppingFinishesWorkAndHandsBackTheQueue) {
  start(1, 100);
  join();
  give_scene(1);
  begin(1, 1);
  for (TileIndex tile = 0; tile < 6; ++tile) master_.send(tile_, wire::TileLease{1, tile, 1});
  EXPECT_EQ(master_.expect<wire::TileResult>().tile, 0u);
  node_->stop();
  std::set<TileIndex> accounted = {0};
  bool is_goodbye = false;
  while (!is_goodbye || accounted.size() < 6) {
    const auto event = master_.next();
    ASSERT_TRUE(event);
    if (!event->message) continue;
    if (const auto* returned = std::get_if<wire::TileReturned>(&*event->message)) {
      EXPECT_TRUE(accounted.insert(returned->tile).second);
    } else if (const auto* result = std::get_if<wire::TileResult>(&*event->message)) {
      EXPECT_TRUE(accounted.insert(result->tile).second);
    } else if (std::holds_alternative<wire::Goodbye>(*event->message) && event->link == tile_) {
      is_goodbye = true;
      EXPECT_EQ(accounted.size(), 6u) << "nothing follows a goodbye";
    }
  }
  EXPECT_EQ(accounted.size(), 6u);
}

TEST_F(SlaveNodeTest, StopsInAnyState) {
  master_.set_away(true);
  start(1, 1);
  node_->stop();
  master_.set_away(false);
  node_.reset();
  start(1, 1);
  (void)master_.expect<wire::Hello>();
  node_.reset();
  SlaveHost never_started(master_.slave_io(), {"x", 1, 1}, master_.factory());
}

}  // namespace
}  // namespace tessera::slave
