// SPDX-License-Identifier: Apache-2.0
// Every message survives the wire, and every field out of range is refused by name.
#include "common/wire/codec.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <set>

#include "tests/unit/wire/wire_samples.h"

namespace tessera::wire {
namespace {

net::ReceivedRecord carry(net::Record record) {
  return {record.type, std::move(record.header),
          std::vector<std::byte>(record.payload.bytes.begin(), record.payload.bytes.end())};
}

TEST(Codec, EveryMessageSurvivesTheWire) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::set<std::size_t> kinds;
    for (const Message& sent : Samples(seed).all()) {
      kinds.insert(sent.index());
      SCOPED_TRACE(message_name(sent));
      net::Record record = encode(sent);
      const bool is_first = std::holds_alternative<RelayJoin>(sent);  // only RelayJoin is
      const net::RecordLimit limit =
          (is_first ? relay_join_limits() : session_limits()).at(record.type);
      EXPECT_LE(static_cast<std::int64_t>(record.header.size()), limit.header_bytes_max);
      EXPECT_LE(static_cast<std::int64_t>(record.payload.bytes.size()), limit.payload_bytes_max);
      const Result<Message> received = decode(carry(std::move(record)));
      ASSERT_TRUE(received.is_ok()) << received.status().message();
      ASSERT_EQ(received->index(), sent.index());
      EXPECT_TRUE(std::visit(
          [&received]<typename M>(const M& m) { return same(m, std::get<M>(*received)); }, sent));
    }
    EXPECT_EQ(kinds.size(), std::variant_size_v<Message>);
  }
}

TEST(Codec, BulkPayloadsAreSharedNotCopied) {
  const net::SharedBytes bytes = net::SharedBytes::of(std::vector<std::byte>(1000));
  EXPECT_EQ(encode(SceneChunk{1, 0, 0, bytes}).payload.bytes.data(), bytes.bytes.data());
  EXPECT_EQ(encode(FrameChunk{1, 0, bytes}).payload.bytes.data(), bytes.bytes.data());
  TileResult result;
  result.version = result.attempt = 1;
  result.pixels.resize(500);
  const std::byte* pixels = result.pixels.data();
  net::Record record = encode(std::move(result));
  EXPECT_EQ(record.payload.bytes.data(), pixels);
  net::ReceivedRecord received = carry(std::move(record));
  pixels = received.payload.data();
  const Result<Message> message = decode(std::move(received));
  ASSERT_TRUE(message.is_ok());
  EXPECT_EQ(std::get<TileResult>(*message).pixels.data(), pixels);
}

// The numbers are the protocol: a change here is a new protocol version.
TEST(Codec, RecordNumbersAreFixed) {
  const std::vector<std::uint16_t> expected = {1,  1,  2,  9,  10, 10, 3,  4,  5,  6,  7,  16, 16,
                                               17, 22, 23, 17, 18, 19, 20, 24, 24, 25, 26, 27, 21,
                                               32, 33, 34, 35, 36, 8,  48, 49, 50, 51, 52, 53};
  std::vector<std::uint16_t> found;
  for (Message& message : Samples(1).all()) found.push_back(encode(std::move(message)).type);
  EXPECT_EQ(found, expected);
}

// One damage to a valid message and the field that must be named.
struct Damage {
  const char* field;
  std::function<void(Samples&, Message&)> apply;
};

template <typename M>
Damage damage(const char* field, std::function<void(M&)> apply) {
  return {field, [apply](Samples& samples, Message& message) {
            for (Message& m : samples.all()) {
              if (std::holds_alternative<M>(m)) {
                message = std::move(m);
                break;
              }
            }
            apply(std::get<M>(message));
          }};
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

std::vector<Damage> handshake_damages() {
  return {
      damage<Hello>("Hello.role", [](Hello& m) { m.role = static_cast<Role>(3); }),
      damage<Hello>("Hello.version_min", [](Hello& m) { m.version_min = 0; }),
      damage<Hello>(
          "Hello.version_max",
          [](Hello& m) { m.version_max = static_cast<std::uint16_t>(m.version_min - 1); }),
      damage<Hello>("Hello.name", [](Hello& m) { m.name.clear(); }),
      damage<Hello>("Hello.name", [](Hello& m) { m.name.assign(kNameBytesMax + 1, 'a'); }),
      damage<Hello>("Hello.build_id",
                    [](Hello& m) { m.build_id.assign(kBuildIdBytesMax + 1, 'a'); }),
      damage<Hello>("Hello.threads", [](Hello& m) { m.threads = 0; }),
      damage<Hello>("Hello.threads", [](Hello& m) { m.threads = kWorkersMax + 1; }),
      damage<Hello>("Hello.isas", [](Hello& m) { m.isas = 0; }),
      damage<Hello>("Hello.isas", [](Hello& m) { m.isas = kIsaMaskAll + 1; }),
      damage<Welcome>("Welcome.version", [](Welcome& m) { m.version = 0; }),
      damage<Welcome>("Welcome.session", [](Welcome& m) { m.session = 0; }),
      damage<Welcome>("Welcome.heartbeat_ms", [](Welcome& m) { m.heartbeat_ms = 0; }),
      damage<Welcome>("Welcome.heartbeat_ms",
                      [](Welcome& m) { m.heartbeat_ms = kHeartbeatMsMax + 1; }),
      damage<Welcome>("Welcome.heartbeats_missed_max",
                      [](Welcome& m) { m.heartbeats_missed_max = 0; }),
      damage<CertificateRequest>("CertificateRequest.der_bytes", [](auto& m) { m.der.clear(); }),
      damage<CertificateGrant>("CertificateGrant.der_bytes", [](auto& m) { m.der.clear(); }),
      damage<Join>("Join.version", [](Join& m) { m.version = 0; }),
      damage<Join>("Join.session", [](Join& m) { m.session = 0; }),
      damage<Refuse>("Refuse.code", [](Refuse& m) { m.code = static_cast<RefuseCode>(8); }),
  };
}

std::vector<Damage> scene_damages() {
  return {
      damage<SceneAnnounce>("SceneAnnounce.version", [](SceneAnnounce& m) { m.version = 0; }),
      damage<SceneAnnounce>("SceneAnnounce.block_count",
                            [](SceneAnnounce& m) {
                              m.digests.clear();
                              m.sizes.clear();
                            }),
      damage<SceneAnnounce>("SceneAnnounce.payload",
                            [](SceneAnnounce& m) { m.sizes.push_back(1); }),
      damage<SceneAnnounce>("SceneAnnounce.sizes", [](SceneAnnounce& m) { m.sizes[0] = 0; }),
      damage<SceneAnnounce>("SceneAnnounce.sizes",
                            [](SceneAnnounce& m) { m.sizes[0] = kSceneBlockBytesMax + 1; }),
      damage<SceneAnnounce>("SceneAnnounce.payload", [](SceneAnnounce& m) { m.is_again = true; }),
      damage<SceneAnnounce>("SceneAnnounce.time_seconds",
                            [](SceneAnnounce& m) { m.time_seconds = -1; }),
      damage<SceneNeed>("SceneNeed.version", [](SceneNeed& m) { m.version = 0; }),
      damage<SceneNeed>("SceneNeed.blocks",
                        [](SceneNeed& m) {
                          m.blocks = {1, 1};
                        }),
      damage<SceneNeed>("SceneNeed.blocks",
                        [](SceneNeed& m) {
                          m.blocks = {2, 1};
                        }),
      damage<SceneNeed>("SceneNeed.blocks", [](SceneNeed& m) { m.blocks = {kSceneBlocksMax}; }),
      damage<SceneChunk>("SceneChunk.version", [](SceneChunk& m) { m.version = 0; }),
      damage<SceneChunk>("SceneChunk.block", [](SceneChunk& m) { m.block = kSceneBlocksMax; }),
      damage<SceneChunk>("SceneChunk.bytes", [](SceneChunk& m) { m.bytes = {}; }),
      damage<SceneChunk>("SceneChunk.offset",
                         [](SceneChunk& m) { m.offset = kSceneBlockBytesMax; }),
      damage<SceneChunk>("SceneChunk.coding",
                         [](SceneChunk& m) { m.coding = static_cast<ByteCoding>(3); }),
      damage<SceneChunkList>("SceneChunkList.version", [](SceneChunkList& m) { m.version = 0; }),
      damage<SceneChunkList>("SceneChunkList.block",
                             [](SceneChunkList& m) { m.block = kSceneBlocksMax; }),
      damage<SceneChunkList>("SceneChunkList.chunk_count",
                             [](SceneChunkList& m) { m.chunks.resize(1); }),
      damage<SceneChunkNeed>("SceneChunkNeed.version", [](SceneChunkNeed& m) { m.version = 0; }),
      damage<SceneChunkNeed>("SceneChunkNeed.block",
                             [](SceneChunkNeed& m) { m.block = kSceneBlocksMax; }),
      damage<SceneChunkNeed>("SceneChunkNeed.chunk_count",
                             [](SceneChunkNeed& m) { m.chunks.clear(); }),
      damage<RelayFrom>("RelayFrom.version", [](RelayFrom& m) { m.version = 0; }),
      damage<RelayFrom>("RelayFrom.host", [](RelayFrom& m) { m.host.clear(); }),
      damage<RelayFrom>("RelayFrom.port", [](RelayFrom& m) { m.port = 0; }),
      damage<RelayFailed>("RelayFailed.version", [](RelayFailed& m) { m.version = 0; }),
      damage<RelayFailed>("RelayFailed.feeder", [](RelayFailed& m) { m.feeder = 0; }),
      damage<RelayFailed>("RelayFailed.fault",
                          [](RelayFailed& m) { m.fault = static_cast<RelayFault>(3); }),
      damage<SceneProgress>("SceneProgress.version", [](SceneProgress& m) { m.version = 0; }),
      damage<SceneBuilt>("SceneBuilt.version", [](SceneBuilt& m) { m.version = 0; }),
      damage<SceneBuilt>("SceneBuilt.build_seconds", [](SceneBuilt& m) { m.build_seconds = kNan; }),
      damage<SceneBuilt>("SceneBuilt.build_seconds", [](SceneBuilt& m) { m.build_seconds = -1; }),
      damage<SceneBuilt>("SceneBuilt.triangle_count",
                         [](SceneBuilt& m) { m.triangle_count = kTrianglesMax + 1; }),
      damage<SceneBuilt>("SceneBuilt.built_primitives",
                         [](SceneBuilt& m) { m.built_primitives = kTrianglesMax + 1; }),
      damage<SceneFailed>("SceneFailed.version", [](SceneFailed& m) { m.version = 0; }),
      damage<SceneRetire>("SceneRetire.first_kept", [](SceneRetire& m) { m.first_kept = 0; }),
  };
}

std::vector<Damage> work_damages() {
  using B = FrameBegin;
  return {
      damage<B>("FrameBegin.version", [](B& m) { m.version = 0; }),
      damage<B>("FrameBegin.isa", [](B& m) { m.isa = static_cast<Isa>(4); }),
      damage<B>("settings.width_px", [](B& m) { m.settings.width_px = 0; }),
      damage<B>("settings.width_px", [](B& m) { m.settings.width_px = -1; }),
      damage<B>("settings.height_px", [](B& m) { m.settings.height_px = kImageSideMaxPx + 1; }),
      damage<B>("settings.renderer", [](B& m) { m.settings.renderer = static_cast<Renderer>(4); }),
      damage<B>("settings.pixel_format",
                [](B& m) { m.settings.pixel_format = static_cast<PixelFormat>(3); }),
      damage<B>("settings.tile_edge_px", [](B& m) { m.settings.tile_edge_px = 3; }),
      damage<B>("settings.samples_per_pixel", [](B& m) { m.settings.samples_per_pixel = 0; }),
      damage<B>("settings.light_samples", [](B& m) { m.settings.light_samples = 257; }),
      damage<B>("settings.bounces", [](B& m) { m.settings.bounces = kBouncesMax + 1; }),
      damage<B>("settings.vpls", [](B& m) { m.settings.vpls = 0; }),
      damage<B>("settings.interleave", [](B& m) { m.settings.interleave = 7; }),
      damage<B>("settings", [](B& m) { m.settings.interleave = 2; }),
      damage<B>("settings", [](B& m) { m.settings.clamp = -2; }),
      damage<B>("settings.pass", [](B& m) { m.settings.pass = kPassesMax; }),
      damage<B>("settings.planes",
                [](B& m) { m.settings.planes = PlaneSet::of_bits(PlaneSet::all().bits() + 1); }),
      damage<B>("settings",
                [](B& m) {
                  m.settings.planes = PlaneSet::all();
                  m.settings.tile_edge_px = kTileEdgeMaxPx;
                }),
      damage<B>("settings",
                [](B& m) {
                  m.settings.planes = {Plane::kAlpha};
                  m.settings.pixel_format = PixelFormat::kFloat;
                  m.settings.width_px = m.settings.height_px = kImageSideMaxPx;
                }),
      damage<B>("settings", [](B& m) { m.settings.camera.target = m.settings.camera.eye; }),
      damage<B>("settings",
                [](B& m) { m.settings.camera.eye.x = std::numeric_limits<float>::infinity(); }),
      damage<B>("settings", [](B& m) { m.settings.camera.vfov_degrees = 180; }),
      damage<TileLease>("TileLease.tile", [](TileLease& m) { m.tile = kTilesPerFrameMax; }),
      damage<TileLease>("TileLease.attempt", [](TileLease& m) { m.attempt = 0; }),
      damage<TileResult>("TileResult.version", [](TileResult& m) { m.version = 0; }),
      damage<TileResult>("TileResult.tile", [](TileResult& m) { m.tile = kTilesPerFrameMax; }),
      damage<TileResult>("TileResult.attempt", [](TileResult& m) { m.attempt = 0; }),
      damage<TileResult>("TileResult.seconds", [](TileResult& m) { m.seconds = kInf; }),
      damage<TileResult>("TileResult.starved_seconds",
                         [](TileResult& m) { m.starved_seconds = -0.5; }),
      damage<TileResult>("TileResult.pixels", [](TileResult& m) { m.pixels.clear(); }),
      damage<TileResult>("TileResult.pixels",
                         [](TileResult& m) { m.pixels.resize(kTilePayloadBytesMax + 1); }),
      damage<TileResult>("TileResult.worker", [](TileResult& m) { m.worker = kWorkersMax; }),
      damage<TileResult>("TileResult.coding",
                         [](TileResult& m) { m.coding = static_cast<ByteCoding>(3); }),
      damage<TileReturned>("TileReturned.tile",
                           [](TileReturned& m) { m.tile = kTilesPerFrameMax; }),
      damage<TileReturned>("TileReturned.attempt", [](TileReturned& m) { m.attempt = 0; }),
      damage<FrameSubmit>("FrameSubmit.version", [](FrameSubmit& m) { m.version = 0; }),
      damage<FrameSubmit>("FrameSubmit.settings", [](FrameSubmit& m) { m.settings.height_px = 0; }),
      damage<FrameChunk>("FrameChunk.bytes", [](FrameChunk& m) { m.bytes = {}; }),
      damage<FrameChunk>("FrameChunk.offset", [](FrameChunk& m) { m.offset = kFrameBytesMax; }),
  };
}

std::vector<Damage> app_damages() {
  using S = StatusReply;
  const auto one = [](std::function<void(SlaveStatus&)> apply) {
    return [apply](S& m) {
      m.status.slaves = {Samples(5).slave_status()};
      apply(m.status.slaves[0]);
    };
  };
  return {
      damage<FrameDone>("FrameDone.seconds", [](FrameDone& m) { m.stats.seconds = kNan; }),
      damage<FrameDone>("FrameDone.isa", [](FrameDone& m) { m.stats.isa = static_cast<Isa>(4); }),
      damage<FrameDone>("FrameDone.slave_count",
                        [](FrameDone& m) { m.stats.slave_count = kConnectionsMax + 1; }),
      damage<FrameDone>("FrameDone.tile_count",
                        [](FrameDone& m) { m.stats.tile_count = kTilesPerFrameMax + 1; }),
      damage<FrameDone>("FrameDone.tile_edge_px",
                        [](FrameDone& m) { m.stats.tile_edge_px = kTileEdgeMaxPx + 1; }),
      damage<FrameDone>("FrameDone.build_seconds",
                        [](FrameDone& m) { m.stats.build_seconds = -1; }),
      damage<FrameDone>("FrameDone.scene_wait_seconds",
                        [](FrameDone& m) { m.stats.scene_cost.wait_seconds = kNan; }),
      damage<FrameDone>("FrameDone.utilisation", [](FrameDone& m) { m.stats.utilisation = kNan; }),
      damage<S>("StatusReply.slaves.name", one([](SlaveStatus& s) { s.name.clear(); })),
      damage<S>("StatusReply.slaves.name", one([](SlaveStatus& s) { s.name = "\n"; })),
      damage<S>("StatusReply.slaves.threads", one([](SlaveStatus& s) { s.threads = 0; })),
      damage<S>("StatusReply.slaves.isa", one([](SlaveStatus& s) { s.isa = static_cast<Isa>(9); })),
      damage<S>("StatusReply.slaves.utilisation",
                one([](SlaveStatus& s) { s.utilisation = kInf; })),
      damage<S>("StatusReply.slaves.rtt_seconds", one([](SlaveStatus& s) { s.rtt_seconds = -1; })),
      damage<S>("StatusReply.quarantined.name",
                [](S& m) {
                  m.status.quarantined = {{"", 1, 1, "lies"}};
                }),
      damage<S>("StatusReply.quarantined.seconds",
                [](S& m) {
                  m.status.quarantined = {{"liar", -1, 1, "lies"}};
                }),
      damage<S>("StatusReply.pace.heartbeat_ms",
                [](S& m) { m.status.pace.heartbeat_ms = kHeartbeatMsMax + 1; }),
      damage<S>("StatusReply.pace.heartbeats_missed_max",
                [](S& m) { m.status.pace.heartbeats_missed_max = kHeartbeatsMissedLimit + 1; }),
      damage<S>("StatusReply.pace.rtt_seconds_max",
                [](S& m) { m.status.pace.rtt_seconds_max = kNan; }),
      damage<S>("StatusReply.pace.tile_seconds_median",
                [](S& m) { m.status.pace.tile_seconds_median = -1; }),
      damage<S>("StatusReply.pace.tile_seconds_p95",
                [](S& m) { m.status.pace.tile_seconds_p95 = kInf; }),
      damage<S>("StatusReply.slaves.state",
                one([](SlaveStatus& s) { s.state = static_cast<SlaveState>(3); })),
      damage<S>("StatusReply.slaves.tiles_per_second",
                one([](SlaveStatus& s) { s.tiles_per_second = kNan; })),
      damage<S>("StatusReply.slaves.tile_seconds",
                one([](SlaveStatus& s) { s.tile_seconds = -1; })),
  };
}

TEST(Codec, EveryFieldOutOfRangeIsRefusedByName) {
  Samples samples(20260101);
  for (const auto& damages :
       {handshake_damages(), scene_damages(), work_damages(), app_damages()}) {
    for (const Damage& d : damages) {
      SCOPED_TRACE(d.field);
      Message message;
      d.apply(samples, message);
      const Result<Message> result = decode(carry(encode(std::move(message))));
      ASSERT_FALSE(result.is_ok());
      EXPECT_EQ(result.status().code(), StatusCode::kDataLoss);
      EXPECT_NE(result.status().message().find(d.field), std::string::npos)
          << result.status().message();
    }
  }
}

TEST(Codec, APayloadOfAnotherLengthIsRefused) {
  // The three bulk messages take any length within their limits; the others exactly one.
  for (const Message& message : Samples(3).all()) {
    if (std::holds_alternative<SceneChunk>(message) ||
        std::holds_alternative<FrameChunk>(message) ||
        std::holds_alternative<TileResult>(message)) {
      continue;
    }
    SCOPED_TRACE(message_name(message));
    net::ReceivedRecord longer = carry(encode(message));
    longer.payload.push_back(std::byte{0});
    EXPECT_FALSE(decode(longer).is_ok());
    net::ReceivedRecord shorter = carry(encode(message));
    if (shorter.payload.empty()) continue;
    shorter.payload.pop_back();
    EXPECT_FALSE(decode(shorter).is_ok());
  }
}

TEST(Codec, DamagedRecordsNeverBreakTheDecoder) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Samples samples(seed);
    for (const Message& message : samples.all()) {
      net::ReceivedRecord record = carry(encode(message));
      if (!record.header.empty()) {
        record.header[samples.number(0, record.header.size() - 1)] ^=
            static_cast<char>(1 << samples.number(0, 7));
      }
      if (!record.payload.empty() && samples.number(0, 1) == 1) {
        record.payload.resize(samples.number(0, record.payload.size()));
      }
      const Result<Message> result = decode(std::move(record));
      if (!result.is_ok()) {
        EXPECT_EQ(result.status().code(), StatusCode::kDataLoss);
      }
    }
  }
}

TEST(Codec, TextsAreCutAndCleanedBySenders) {
  const std::string dirty = "a\nb\xff" + std::string(5000, 'x');
  const Result<Message> result = decode(carry(encode(Refuse{RefuseCode::kBusy, dirty})));
  ASSERT_TRUE(result.is_ok()) << result.status().message();
  const std::string& reason = std::get<Refuse>(*result).reason;
  EXPECT_EQ(reason.size(), kReasonBytesMax);
  EXPECT_TRUE(reason.starts_with("a?b?xx"));
}

TEST(Codec, UnknownTypesHaveNoLimitsAndAreRefused) {
  std::set<std::uint16_t> known;
  for (Message& message : Samples(1).all()) known.insert(encode(std::move(message)).type);
  for (std::uint16_t type = 0; type < net::kRecordTypesMax; ++type) {
    const bool is_relay_join = type == 27;  // on connections between slaves alone
    EXPECT_EQ(session_limits().at(type).header_bytes_max >= 0,
              known.contains(type) && !is_relay_join)
        << type;
    if (!known.contains(type)) {
      EXPECT_FALSE(decode({type, "", {}}).is_ok());
    }
  }
  EXPECT_FALSE(decode({net::kRecordTypesMax, "", {}}).is_ok());
  EXPECT_FALSE(decode({0xffff, "", {}}).is_ok());
}

TEST(Codec, BeforeTheHandshakeOnlyItsOwnRecordsAreAllowed) {
  for (std::uint16_t type = 0; type < net::kRecordTypesMax; ++type) {
    const bool is_allowed = type == 1 || type == 3 || type == 5;  // Hello, Join, Refuse
    const net::RecordLimit limit = pre_auth_limits().at(type);
    EXPECT_EQ(limit.header_bytes_max, is_allowed ? std::int64_t{kPreAuthRecordBytesMax} : -1);
    EXPECT_EQ(limit.payload_bytes_max, 0);
  }
}

}  // namespace
}  // namespace tessera::wire
