// SPDX-License-Identifier: Apache-2.0
// Slaves that break the protocol: they are expelled, their tiles are rendered by others, and not
// one of their bytes reaches a frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <future>

#include "common/base/limits.h"
#include "common/frame/faulty_pixels.h"
#include "common/net/connector.h"
#include "common/scene/scene_summary.h"
#include "common/wire/codec.h"
#include "master/cluster/quarantine.h"
#include "master/session/master_host.h"
#include "tests/support/net_peer.h"
#include "tests/support/small_scene.h"

namespace tessera::master {
namespace {

constexpr std::byte kHonest{0x2a}, kFalse{0x66};

net::ConnectionPtr dial(net::IoThread& io, std::uint16_t port) {
  auto promise = std::make_shared<std::promise<net::ConnectionPtr>>();
  std::unique_ptr<net::ConnectAttempt> attempt;
  io.run_and_wait([&] {
    attempt = net::connect(io, {"127.0.0.1", port}, nullptr, "master", test::kPatience,
                           [promise](Result<net::ConnectionPtr> result) {
                             promise->set_value(result.is_ok() ? *result : nullptr);
                           });
  });
  net::ConnectionPtr connection = promise->get_future().get();
  io.run_and_wait([&] { attempt.reset(); });
  EXPECT_TRUE(connection);
  return connection;
}

void say(test::NetPeer& link, wire::Message message) {
  const net::Record record = wire::encode(std::move(message));
  link.send(record.type, record.header, {record.payload.bytes.begin(), record.payload.bytes.end()});
}

// A slave driven by hand: it acknowledges the scene without reading it, then says what the test
// says.
class HandSlave {
 public:
  HandSlave(net::IoThread& io, std::uint16_t port, const std::string& name)
      : tile_(io), scene_(io) {
    tile_.adopt(dial(io, port), wire::session_limits());
    wire::Hello hello;
    hello.name = name;
    hello.threads = 1;
    hello.isas = isa_bit(Isa::kScalar);
    hello.build_id = "by hand";
    say(tile_, hello);
    const auto welcome = hear<wire::Welcome>(tile_);
    scene_.adopt(dial(io, port), wire::session_limits());
    say(scene_, wire::Join{welcome.version, welcome.session, welcome.token});
    hear<wire::Joined>(scene_);
  }

  void say_on_tile_link(wire::Message message) { say(tile_, std::move(message)); }
  void say_on_scene_link(wire::Message message) { say(scene_, std::move(message)); }

  void build_scene(bool builds_wrong_scene = false) {
    const auto announce = hear<wire::SceneAnnounce>(scene_);
    say(scene_, wire::SceneNeed{announce.version, {}});
    wire::SceneBuilt built{announce.version, 0.01, 4, scene_digest(announce.digests)};
    if (builds_wrong_scene) built.scene.bytes[7] ^= 1;
    say(scene_, built);
  }

  // Returns: the next message that is not a heartbeat. When that is no M, the test fails, with a
  // default M.
  template <typename M>
  M hear(test::NetPeer& link) {
    while (auto record = link.next_record()) {
      auto message = wire::decode(std::move(*record));
      EXPECT_TRUE(message.is_ok()) << message.status().message();
      if (!message.is_ok()) break;
      if (const auto* ping = std::get_if<wire::Ping>(&*message)) {
        say(link, wire::Pong{ping->sent_ns});
        continue;
      }
      if (auto* wanted = std::get_if<M>(&*message)) return std::move(*wanted);
      ADD_FAILURE() << "instead came " << wire::message_name(*message);
      return {};
    }
    ADD_FAILURE() << "the link ended";
    return {};
  }
  wire::FrameBegin hear_frame() { return begin_ = hear<wire::FrameBegin>(tile_); }
  wire::TileLease hear_lease() { return hear<wire::TileLease>(tile_); }

  wire::TileResult answer_to(const wire::TileLease& lease, std::byte fill) const {
    const FrameSettings& s = begin_.settings;
    const TileGrid grid(s.width_px, s.height_px, s.tile_edge_px);
    wire::TileResult result;
    result.frame = lease.frame;
    result.version = begin_.version;
    result.tile = lease.tile;
    result.attempt = lease.attempt;
    result.pixels.assign(static_cast<std::size_t>(grid.rect(lease.tile).pixel_count() *
                                                  bytes_per_pixel(s.pixel_format)),
                         fill);
    return result;
  }

  // The reason that the master gives before it closes.
  std::string hear_refusal() {
    while (auto record = tile_.next_record()) {
      auto message = wire::decode(std::move(*record));
      if (!message.is_ok()) break;
      if (const auto* refuse = std::get_if<wire::Refuse>(&*message)) return refuse->reason;
    }
    return "";
  }

 private:
  test::NetPeer tile_, scene_;
  wire::FrameBegin begin_;
};

class HostileSlave : public ::testing::Test {
 protected:
  void SetUp() override {
    SessionOptions options;
    options.local_slaves = 0;
    options.listen = "127.0.0.1:0";
    options.is_plain = true;
    auto host = MasterHost::start(options, false);
    ASSERT_TRUE(host.is_ok()) << host.status().message();
    host_ = std::move(*host);
    host_->io().run_and_wait([this] {
      FrameLoop& loop = host_->frame_loop();
      loop.set_outcome_callback([this](FrameOutcome o) { outcome_.set_value(std::move(o)); });
      SceneEncoder encoder;
      loop.commit_scene(1, encoder.encode(test::make_small_scene()));
      FrameSettings settings;
      settings.width_px = 48;
      settings.height_px = 32;
      settings.tile_edge_px = 16;
      loop.submit(0, 1, settings);
    });
  }

  void TearDown() override { host_.reset(); }  // before the promise that its callback sets

  HandSlave slave(const std::string& name) { return {io_, host_->listen_port(), name}; }

  // How the master refuses a connection that begins with `first`.
  wire::Refuse refusal_of(wire::Message first) {
    test::NetPeer guest(io_);
    guest.adopt(dial(io_, host_->listen_port()), wire::session_limits());
    say(guest, std::move(first));
    auto record = guest.next_record();
    EXPECT_TRUE(record.has_value());
    if (!record) return {};
    auto message = wire::decode(std::move(*record));
    EXPECT_TRUE(message.is_ok() && std::holds_alternative<wire::Refuse>(*message));
    EXPECT_FALSE(guest.wait_for_end().is_ok());
    return message.is_ok() ? std::get<wire::Refuse>(*message) : wire::Refuse{};
  }

  // An honest slave renders what is left; the frame has its bytes only.
  void expect_whole_frame_from_another(int tiles_left = 6) {
    HandSlave honest = slave("honest");
    honest.build_scene();
    honest.hear_frame();
    for (int i = 0; i < tiles_left; ++i) {
      honest.say_on_tile_link(honest.answer_to(honest.hear_lease(), kHonest));
    }
    auto future = outcome_.get_future();
    ASSERT_EQ(future.wait_for(test::kPatience), std::future_status::ready);
    const FrameOutcome outcome = future.get();
    ASSERT_TRUE(outcome.status.is_ok()) << outcome.status.message();
    EXPECT_TRUE(std::all_of(outcome.image->bytes.begin(), outcome.image->bytes.end(),
                            [](std::byte b) { return b == kHonest; }));
  }

  // A liar with one lease in hand says what `lie` makes of the true answer.
  void expect_expelled(const std::function<wire::Message(wire::TileResult)>& lie) {
    {
      HandSlave liar = slave("liar");
      liar.build_scene();
      liar.hear_frame();
      liar.say_on_tile_link(lie(liar.answer_to(liar.hear_lease(), kFalse)));
      EXPECT_NE(liar.hear_refusal(), "");
    }
    expect_whole_frame_from_another();
  }

  net::IoThread io_{"test-net"};
  std::unique_ptr<MasterHost> host_;
  std::promise<FrameOutcome> outcome_;
};

TEST_F(HostileSlave, AResultOfTheWrongSize) {
  expect_expelled([](wire::TileResult r) {
    r.pixels.resize(r.pixels.size() - 1);
    return r;
  });
}

TEST_F(HostileSlave, AResultForATileThatItNeverGot) {
  expect_expelled([](wire::TileResult r) {
    r.tile = 5;
    return r;
  });
}

TEST_F(HostileSlave, AResultForATileThatDoesNotExist) {
  expect_expelled([](wire::TileResult r) {
    r.tile = 4'000'000'000u;
    return r;
  });
}

TEST_F(HostileSlave, AResultOfAnotherAttempt) {
  expect_expelled([](wire::TileResult r) {
    ++r.attempt;
    return r;
  });
}

TEST_F(HostileSlave, AResultOfAnotherSceneVersion) {
  expect_expelled([](wire::TileResult r) {
    ++r.version;
    return r;
  });
}

TEST_F(HostileSlave, AResultOfAFrameThatNeverWas) {
  expect_expelled([](wire::TileResult r) {
    r.frame = 77;
    return r;
  });
}

TEST_F(HostileSlave, AMessageThatOnlyAnApplicationMaySend) {
  expect_expelled([](const wire::TileResult&) { return wire::FrameSubmit{1, 1, FrameSettings{}}; });
}

TEST_F(HostileSlave, AMessageThatOnlyAMasterMaySend) {
  expect_expelled([](const wire::TileResult&) { return wire::TileLease{0, 0, 1}; });
}

TEST_F(HostileSlave, AsksForASceneBlockThatDoesNotExist) {
  {
    HandSlave liar = slave("liar");
    liar.say_on_scene_link(wire::SceneNeed{1, {4000}});
    EXPECT_NE(liar.hear_refusal(), "");
  }
  expect_whole_frame_from_another();
}

TEST_F(HostileSlave, TheSameResultAgainIsDroppedAndForgivenUntilItIsTooMuch) {
  {
    HandSlave parrot = slave("parrot");
    parrot.build_scene();
    parrot.hear_frame();
    const wire::TileLease lease = parrot.hear_lease();
    for (int i = 0; i < kTilesPerWorkerMax + 1;
         ++i) {  // an answer, then as many repeats as are forgiven
      parrot.say_on_tile_link(parrot.answer_to(lease, kHonest));
    }
    host_->io().run_and_wait(
        [this] { EXPECT_EQ(host_->frame_loop().status().slaves.size(), 1u) << "forgiven so far"; });
    parrot.say_on_tile_link(parrot.answer_to(lease, kHonest));
    EXPECT_NE(parrot.hear_refusal().find("again"), std::string::npos);
  }
  expect_whole_frame_from_another(5);
}

TEST_F(HostileSlave, WhoLiedIsHeldBackByNameAndShownInStatus) {
  {
    HandSlave liar = slave("liar");
    liar.say_on_scene_link(wire::SceneNeed{1, {4000}});
    EXPECT_NE(liar.hear_refusal(), "");
  }
  wire::Hello hello;
  hello.name = "liar";
  hello.threads = 1;
  hello.isas = isa_bit(Isa::kScalar);
  const wire::Refuse refuse = refusal_of(hello);
  EXPECT_EQ(refuse.code, wire::RefuseCode::kFull) << "it may try again, later";
  EXPECT_NE(refuse.reason.find("held back"), std::string::npos) << refuse.reason;
  host_->io().run_and_wait([this] {
    const auto held = host_->frame_loop().status().quarantined;
    ASSERT_EQ(held.size(), 1u);
    EXPECT_EQ(held[0].name, "liar");
  });
  expect_whole_frame_from_another();
}

// Bytes of 0xff are NaN in every format of floats.
TEST_F(HostileSlave, NanPixelsAreRenderedAgainByAnotherAndNoneIsLeft) {
  HandSlave sick = slave("sick");
  sick.build_scene();
  sick.hear_frame();
  HandSlave honest = slave("honest");
  honest.build_scene();
  honest.hear_frame();
  for (std::size_t i = 0; i < Quarantine::kWrongMax; ++i)
    sick.say_on_tile_link(sick.answer_to(sick.hear_lease(), std::byte{0xff}));
  auto future = outcome_.get_future();
  // The sick slave holds other leases, too; it leaves, and the honest one renders all.
  sick.say_on_tile_link(wire::Goodbye{"unwell"});
  for (int i = 0; i < 6; ++i) {
    honest.say_on_tile_link(honest.answer_to(honest.hear_lease(), kHonest));
  }
  ASSERT_EQ(future.wait_for(test::kPatience), std::future_status::ready);
  const FrameOutcome outcome = future.get();
  ASSERT_TRUE(outcome.status.is_ok()) << outcome.status.message();
  EXPECT_TRUE(std::all_of(outcome.image->bytes.begin(), outcome.image->bytes.end(),
                          [](std::byte b) { return b == kHonest; }));
  EXPECT_EQ(outcome.stats.tiles_faulty, Quarantine::kWrongMax);
  EXPECT_EQ(outcome.stats.pixels_faulty, 0u);
  host_->io().run_and_wait([this] {
    const auto held = host_->frame_loop().status().quarantined;
    ASSERT_EQ(held.size(), 1u) << "it was gone before anybody knew that its pixels were wrong";
    EXPECT_EQ(held[0].name, "sick");
  });
}

TEST_F(HostileSlave, NanPixelsOfTheOnlySlaveAreReplacedAndCounted) {
  HandSlave sick = slave("sick");
  sick.build_scene();
  sick.hear_frame();
  auto future = outcome_.get_future();
  for (int i = 0; i < 6; ++i) {
    sick.say_on_tile_link(sick.answer_to(sick.hear_lease(), i == 0 ? std::byte{0xff} : kHonest));
  }
  ASSERT_EQ(future.wait_for(test::kPatience), std::future_status::ready);
  const FrameOutcome outcome = future.get();
  ASSERT_TRUE(outcome.status.is_ok()) << outcome.status.message();
  EXPECT_EQ(count_faulty_pixels(outcome.image->bytes, outcome.image->format), 0u);
  EXPECT_EQ(outcome.stats.tiles_faulty, 1u);
  EXPECT_EQ(outcome.stats.pixels_faulty, 16u * 16);
}

TEST_F(HostileSlave, LeavesInMidFrame) {
  {
    HandSlave deserter = slave("deserter");
    deserter.build_scene();
    deserter.hear_frame();
    deserter.hear_lease();
  }
  expect_whole_frame_from_another();
}

TEST_F(HostileSlave, JoinsASessionThatIsNotItsOwn) {
  const wire::Refuse refuse = refusal_of(wire::Join{1, 12345, 67890});
  EXPECT_EQ(refuse.code, wire::RefuseCode::kSession);
  expect_whole_frame_from_another();
}

TEST_F(HostileSlave, SpeaksAnotherVersionOfTheProtocol) {
  wire::Hello hello;
  hello.version_min = 7;
  hello.version_max = 9;
  hello.name = "future";
  hello.threads = 1;
  hello.isas = isa_bit(Isa::kScalar);
  const wire::Refuse refuse = refusal_of(hello);
  EXPECT_EQ(refuse.code, wire::RefuseCode::kVersion);
  EXPECT_NE(refuse.reason.find("7 to 9"), std::string::npos) << refuse.reason;
  expect_whole_frame_from_another();
}

TEST_F(HostileSlave, BuildsAnotherSceneAndGetsNoTiles) {
  const HandSlave bystander = slave("bystander");  // while it may still build, no frame is given up
  HandSlave liar = slave("liar");
  liar.build_scene(true);
  expect_whole_frame_from_another();
}

TEST_F(HostileSlave, BeginsWithSomethingElseThanHello) {
  test::NetPeer guest(io_);
  guest.adopt(dial(io_, host_->listen_port()), wire::session_limits());
  say(guest, wire::SceneBuilt{1, 0, 0, {}});
  EXPECT_FALSE(guest.wait_for_end().is_ok());
  EXPECT_FALSE(guest.next_record().has_value()) << "nothing is told to who is not known";
}

}  // namespace
}  // namespace tessera::master
