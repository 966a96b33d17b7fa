// SPDX-License-Identifier: Apache-2.0
// Random valid messages and a field-by-field comparison, for the codec's tests.
//
// Threads. Test thread only. Reproducible from the seed of the engine.
#pragma once

#include <algorithm>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "common/wire/messages.h"
#include "common/wire/record_types.h"

namespace tessera::wire {

class Samples {
 public:
  explicit Samples(std::uint64_t seed) : random_(seed) {}

  // At least one message of every type.
  std::vector<Message> all();

  std::uint64_t number(std::uint64_t least, std::uint64_t greatest) {
    return std::uniform_int_distribution<std::uint64_t>(least, greatest)(random_);
  }
  std::uint32_t small(std::uint64_t least, std::uint64_t greatest) {
    return static_cast<std::uint32_t>(number(least, greatest));
  }
  std::uint64_t any() { return random_(); }
  double real(double least, double greatest) {
    return std::uniform_real_distribution<double>(least, greatest)(random_);
  }
  float real_f() { return static_cast<float>(real(-100, 100)); }
  std::string text(std::size_t bytes_max, std::size_t bytes_min = 1) {
    std::string s(number(bytes_min, bytes_max), ' ');
    for (char& c : s) c = static_cast<char>(number(0x20, 0x7e));
    return s;
  }
  std::vector<std::byte> bytes(std::size_t count_max) {
    std::vector<std::byte> b(number(1, count_max));
    for (std::byte& x : b) x = static_cast<std::byte>(number(0, 255));
    return b;
  }
  Digest digest() {
    Digest d;
    for (auto& b : d.bytes) b = static_cast<std::uint8_t>(number(0, 255));
    return d;
  }
  Isa isa() { return static_cast<Isa>(number(0, 3)); }
  RayCounts rays() { return {any(), any(), any()}; }

  FrameSettings settings() {
    FrameSettings s;
    s.width_px = static_cast<int>(number(1, kImageSideMaxPx));
    s.height_px = static_cast<int>(number(1, kImageSideMaxPx));
    s.camera.eye = {real_f(), real_f(), real_f()};
    s.camera.target = {real_f() + 300, real_f(), real_f()};  // never the eye
    s.camera.up = {0, real_f() + 200, real_f()};             // never along the view
    s.camera.vfov_degrees = static_cast<float>(real(1, 170));
    s.renderer = static_cast<Renderer>(number(0, 3));
    s.pixel_format = static_cast<PixelFormat>(number(0, 2));
    s.tile_edge_px = static_cast<int>(number(kTileEdgeMinPx, kTileEdgeMaxPx));
    s.samples_per_pixel = static_cast<int>(number(1, kSamplesPerPixelMax));
    s.light_samples = static_cast<int>(number(1, kLightSamplesMax));
    s.bounces = static_cast<int>(number(0, kBouncesMax));
    s.vpls = static_cast<int>(number(1, kVplsMax));
    s.interleave = 1 + 2 * static_cast<int>(number(0, 2));
    s.is_filtered = number(0, 1) == 1;
    s.clamp = static_cast<float>(real(0, 100));
    s.is_compensated = number(0, 1) == 1;
    s.pass = small(0, kPassesMax - 1);
    s.seed = small(0, 0xffffffffu);
    s.time_seconds = 1e-3 * small(0, 1u << 30);
    s.display = {static_cast<float>(real(-64, 64)), static_cast<ToneCurve>(number(0, 3))};
    s.patch_method = static_cast<PatchMethod>(number(0, 4));
    if (number(0, 1) == 1) {
      s.planes = PlaneSet::of_bits(small(1, PlaneSet::all().bits()));
      s.width_px = static_cast<int>(number(1, 4000));
      s.height_px = static_cast<int>(number(1, 4000));
      s.tile_edge_px = static_cast<int>(number(kTileEdgeMinPx, 96));
    }
    return s;
  }

  FrameStats stats() {
    FrameStats s;
    s.frame = any();
    s.seconds = real(0, 100);
    s.scene_version = any();
    s.isa = isa();
    s.is_mixed = number(0, 1) == 1;
    s.slave_count = small(0, kConnectionsMax);
    s.tile_count = small(0, kTilesPerFrameMax);
    s.tile_edge_px = small(0, kTileEdgeMaxPx);
    s.tiles_reissued = small(0, 0xffffffffu);
    s.tiles_rejected = small(0, 0xffffffffu);
    s.rays = rays();
    s.bytes_to_slaves = any();
    s.bytes_from_slaves = any();
    s.build_seconds = real(0, 100);
    s.scene_cost = {any(), real(0, 100), any()};
    s.utilisation = real(0, 1);
    s.digest = digest();
    return s;
  }

  StatusReply status_reply();

  SlaveStatus slave_status() {
    SlaveStatus s;
    s.name = text(kNameBytesMax);
    s.threads = small(1, kWorkersMax);
    s.isa = isa();
    s.tiles_in_flight = small(0, 0xffffffffu);
    s.tiles_done = any();
    s.utilisation = real(0, 1);
    s.rtt_seconds = real(0, 10);
    s.scene_version = any();
    s.tile_port = static_cast<std::uint16_t>(number(0, 0xffff));
    s.scene_port = static_cast<std::uint16_t>(number(0, 0xffff));
    s.state = static_cast<SlaveState>(number(0, 2));
    s.ordinal = static_cast<std::uint16_t>(number(0, 0xffff));
    s.prefetch_depth = small(0, 0xffffffffu);
    s.tiles_per_second = real(0, 1e6);
    s.tile_seconds = real(0, 10);
    s.tiles = {any(), any(), any(), any(), s.tiles_in_flight};
    s.queue_bytes = any();
    s.bytes_sent = any();
    s.bytes_received = any();
    return s;
  }

 private:
  void add_scene_messages(std::vector<Message>& m);

  std::mt19937_64 random_;
};

inline void Samples::add_scene_messages(std::vector<Message>& m) {
  const auto u16 = [this] { return static_cast<std::uint16_t>(number(1, 0xffff)); };
  SceneAnnounce announce;
  announce.version = number(1, ~0ull);
  for (std::uint64_t i = number(1, 20); i > 0; --i) {
    announce.digests.push_back(digest());
    announce.sizes.push_back(number(1, kSceneBlockBytesMax));
  }
  announce.index_bytes = any();
  announce.time_seconds = 1e-3 * small(0, 1u << 30);
  m.push_back(announce);
  SceneAnnounce again;
  again.version = number(1, ~0ull);
  again.is_again = true;
  again.time_seconds = 1e-3 * small(0, 1u << 30);
  for (std::uint32_t i = small(0, 60); i < 40; i += small(1, 9)) {
    again.places.push_back(i);
    again.digests.push_back(digest());
    again.sizes.push_back(number(1, kSceneBlockBytesMax));
  }
  m.push_back(again);
  SceneNeed need;
  need.version = number(1, ~0ull);
  for (std::uint32_t i = small(0, 5); i < 40; i += small(1, 9)) need.blocks.push_back(i);
  need.codings = small(0, 3) * coding_bit(ByteCoding::kLz4);
  m.push_back(need);
  SceneChunkList list{number(1, ~0ull), small(0, kSceneBlocksMax - 1), {}};
  for (std::uint64_t i = number(2, 30); i > 0; --i) list.chunks.push_back(digest());
  m.push_back(list);
  SceneChunkNeed chunk_need{number(1, ~0ull), small(0, kSceneBlocksMax - 1), {}};
  for (std::uint64_t i = number(1, 30); i > 0; --i) {
    chunk_need.chunks.push_back(number(0, 1) == 1);
  }
  m.push_back(chunk_need);
  m.push_back(SceneNeed{7, {}, 0});
  m.push_back(SceneChunk{number(1, ~0ull), small(0, kSceneBlocksMax - 1),
                         number(0, kSceneBlockBytesMax - 4096), net::SharedBytes::of(bytes(4096)),
                         static_cast<ByteCoding>(number(0, 2))});
  m.push_back(SceneBuilt{number(1, ~0ull), real(0, 100), number(0, kTrianglesMax), digest(),
                         number(0, kTrianglesMax)});
  m.push_back(SceneFailed{number(1, ~0ull), text(kReasonBytesMax, 0), any(), any()});
  m.push_back(RelayFrom{number(1, ~0ull), number(1, ~0ull), text(kNameBytesMax), u16(), any()});
  m.push_back(RelayFrom{number(1, ~0ull), 0, "", 0, 0});
  m.push_back(RelayFailed{number(1, ~0ull), number(1, ~0ull), static_cast<RelayFault>(number(0, 2)),
                          text(kReasonBytesMax, 0)});
  m.push_back(SceneProgress{number(1, ~0ull), any()});
  m.push_back(RelayJoin{any(), small(0, 3) * coding_bit(ByteCoding::kLz4)});
  m.push_back(SceneRetire{number(1, ~0ull), number(0, 1) == 1});
}

inline std::vector<Message> Samples::all() {
  std::vector<Message> m;
  const auto u16 = [this] { return static_cast<std::uint16_t>(number(1, 0xffff)); };
  const std::uint16_t least = static_cast<std::uint16_t>(number(1, 1000));
  m.push_back(Hello{Role::kSlave, least, static_cast<std::uint16_t>(least + number(0, 9)),
                    text(kNameBytesMax), small(1, kWorkersMax), small(1, kIsaMaskAll),
                    text(kBuildIdBytesMax, 0), any(), u16(), any()});
  m.push_back(Hello{static_cast<Role>(number(1, 2)), 1, 1, text(kNameBytesMax), 0, 0, ""});
  m.push_back(Welcome{u16(), number(1, ~0ull), any(), small(1, kHeartbeatMsMax),
                      small(1, kHeartbeatsMissedLimit), number(0, 1) == 1});
  m.push_back(CertificateRequest{bytes(number(1, kCertificateBytesMax))});
  m.push_back(CertificateGrant{bytes(number(1, kCertificateBytesMax)), ""});
  m.push_back(CertificateGrant{{}, text(kReasonBytesMax, 1)});
  m.push_back(Join{u16(), number(1, ~0ull), any()});
  m.push_back(Joined{});
  m.push_back(Refuse{static_cast<RefuseCode>(number(0, 7)), text(kReasonBytesMax, 0)});
  m.push_back(Ping{any()});
  m.push_back(Pong{any(), any()});
  add_scene_messages(m);
  m.push_back(FrameBegin{any(), number(1, ~0ull), isa(), settings(),
                         small(0, 3) * coding_bit(ByteCoding::kLz4)});
  m.push_back(TileLease{any(), small(0, kTilesPerFrameMax - 1), small(1, 0xffffffffu)});
  m.push_back(FrameEnd{any()});
  m.push_back(TileResult{any(), number(1, ~0ull), small(0, kTilesPerFrameMax - 1),
                         small(1, 0xffffffffu), real(0, 10), real(0, 10), real(0, 10), rays(),
                         any(), small(0, kWorkersMax - 1), bytes(5000),
                         static_cast<ByteCoding>(number(0, 2))});
  m.push_back(TileReturned{any(), small(0, kTilesPerFrameMax - 1), small(1, 0xffffffffu)});
  m.push_back(Goodbye{text(kReasonBytesMax, 0)});
  m.push_back(FrameSubmit{any(), number(1, ~0ull), settings()});
  m.push_back(FrameCancel{any()});
  m.push_back(
      FrameChunk{any(), number(0, kFrameBytesMax - 4096), net::SharedBytes::of(bytes(4096))});
  FrameDone done;
  done.stats = stats();
  done.error = text(kReasonBytesMax, 0);
  for (std::uint64_t i = number(0, 30); i > 0; --i) {
    done.tile_slave.push_back(static_cast<std::uint16_t>(number(0, 0xffff)));
  }
  m.push_back(done);
  m.push_back(StatusRequest{number(0, 1) == 1, number(0, 1) == 1});
  m.push_back(status_reply());
  return m;
}

inline StatusReply Samples::status_reply() {
  StatusReply reply;
  reply.status.frames_done = any();
  reply.status.has_application = number(0, 1) == 1;
  reply.status.frames_failed = any();
  reply.status.frames_cancelled = any();
  reply.status.frames_open = small(0, 9999);
  reply.status.tiles_reissued = any();
  reply.status.slaves_lost = any();
  for (std::uint64_t i = number(0, 5); i > 0; --i) reply.status.slaves.push_back(slave_status());
  reply.status.pace = {small(0, kHeartbeatMsMax),
                       small(0, kHeartbeatsMissedLimit),
                       small(0, 9999),
                       small(0, 9999),
                       0.25,
                       0.5,
                       1.5};
  reply.status.tiles = {any(), any(), any(), any(), any()};
  for (std::uint64_t i = number(0, 3); i > 0; --i) {
    reply.status.quarantined.push_back(
        {text(kNameBytesMax, 1), 12.5, small(0, 9999), text(kQuarantineReasonBytesMax, 0)});
  }
  reply.status.alone_reason = text(kAloneReasonBytesMax, 0);
  for (std::uint64_t i = number(0, 3); i > 0; --i)
    reply.status.events.push_back(
        {0.5, static_cast<std::uint8_t>(number(0, 5)), text(kEventLineBytesMax, 0)});
  for (std::uint64_t i = number(0, 3); i > 0; --i)
    reply.status.suppressed.push_back({text(kNameBytesMax, 1), any()});
  return reply;
}

// ---- field by field -----------------------------------------------------------------------------
inline bool same_bytes(const net::SharedBytes& a, const net::SharedBytes& b) {
  return std::ranges::equal(a.bytes, b.bytes);
}
inline auto fields(const Hello& m) {
  return std::tie(m.role, m.version_min, m.version_max, m.name, m.threads, m.isas, m.build_id,
                  m.memory_bytes, m.relay_port, m.relay_token, m.instance);
}
inline auto fields(const Welcome& m) {
  return std::tie(m.version, m.session, m.token, m.heartbeat_ms, m.heartbeats_missed_max,
                  m.issues_certificates);
}
inline auto fields(const CertificateRequest& m) { return std::tie(m.der); }
inline auto fields(const CertificateGrant& m) { return std::tie(m.der, m.reason); }
inline auto fields(const Join& m) { return std::tie(m.version, m.session, m.token); }
inline auto fields(const Joined&) { return std::tuple<>(); }
inline auto fields(const Refuse& m) { return std::tie(m.code, m.reason); }
inline auto fields(const Ping& m) { return std::tie(m.sent_ns); }
inline auto fields(const Pong& m) { return std::tie(m.sent_ns, m.answered_ns); }
inline auto fields(const SceneAnnounce& m) {
  return std::tie(m.version, m.digests, m.sizes, m.index_bytes, m.is_again, m.places,
                  m.time_seconds);
}
inline auto fields(const SceneChunkList& m) { return std::tie(m.version, m.block, m.chunks); }
inline auto fields(const SceneChunkNeed& m) { return std::tie(m.version, m.block, m.chunks); }
inline auto fields(const SceneNeed& m) { return std::tie(m.version, m.blocks, m.codings); }
inline auto fields(const SceneChunk& m) { return std::tie(m.version, m.block, m.offset, m.coding); }
inline auto fields(const SceneBuilt& m) {
  return std::tie(m.version, m.build_seconds, m.triangle_count, m.scene, m.built_primitives);
}
inline auto fields(const SceneFailed& m) {
  return std::tie(m.version, m.reason, m.needed_bytes, m.free_bytes);
}
inline auto fields(const RelayFrom& m) {
  return std::tie(m.version, m.feeder, m.host, m.port, m.token);
}
inline auto fields(const RelayFailed& m) {
  return std::tie(m.version, m.feeder, m.fault, m.reason);
}
inline auto fields(const SceneProgress& m) { return std::tie(m.version, m.bytes); }
inline auto fields(const RelayJoin& m) { return std::tie(m.token, m.codings); }
inline auto fields(const SceneRetire& m) { return std::tie(m.first_kept, m.keeps_newest); }
inline auto fields(const FrameBegin& m) {
  return std::tie(m.frame, m.version, m.isa, m.settings, m.pixel_codings);
}
inline auto fields(const TileLease& m) { return std::tie(m.frame, m.tile, m.attempt); }
inline auto fields(const FrameEnd& m) { return std::tie(m.frame); }
inline auto fields(const TileResult& m) {
  return std::tie(m.frame, m.version, m.tile, m.attempt, m.seconds, m.starved_seconds,
                  m.held_seconds, m.rays, m.began_ns, m.worker, m.pixels, m.coding);
}
inline auto fields(const TileReturned& m) { return std::tie(m.frame, m.tile, m.attempt); }
inline auto fields(const Goodbye& m) { return std::tie(m.reason); }
inline auto fields(const FrameSubmit& m) { return std::tie(m.frame, m.version, m.settings); }
inline auto fields(const FrameCancel& m) { return std::tie(m.frame); }
inline auto fields(const FrameChunk& m) { return std::tie(m.frame, m.offset); }
inline auto fields(const StatusRequest& m) { return std::tie(m.wants_details, m.wants_events); }
inline auto fields(const FrameStats& s) {
  return std::tie(s.frame, s.seconds, s.scene_version, s.isa, s.is_mixed, s.slave_count,
                  s.tile_count, s.tile_edge_px, s.tiles_reissued, s.tiles_rejected, s.rays,
                  s.bytes_to_slaves, s.bytes_from_slaves, s.build_seconds, s.utilisation,
                  s.tiles_duplicated, s.tiles_faulty, s.pixels_faulty, s.render_seconds,
                  s.prefetch_min, s.prefetch_max, s.completed_at_seconds, s.digest, s.scene_cost);
}
inline auto fields(const FrameDone& m) {
  return std::tuple_cat(fields(m.stats), std::tie(m.error, m.is_final, m.tile_slave));
}
inline auto fields(const SlaveStatus& s) {
  return std::tie(s.name, s.threads, s.isa, s.tiles_in_flight, s.tiles_done, s.utilisation,
                  s.rtt_seconds, s.scene_version, s.tile_port, s.scene_port, s.state, s.ordinal,
                  s.prefetch_depth, s.tiles_per_second, s.tile_seconds, s.tiles, s.queue_bytes,
                  s.bytes_sent, s.bytes_received);
}
inline auto fields(const ClusterStatus& s) {
  return std::tie(s.frames_done, s.has_application, s.frames_failed, s.frames_cancelled,
                  s.frames_open, s.tiles, s.pace, s.tiles_reissued, s.slaves_lost, s.alone_reason,
                  s.events, s.suppressed);
}

template <typename M>
bool same(const M& a, const M& b) {
  return fields(a) == fields(b);
}
inline bool same(const SceneChunk& a, const SceneChunk& b) {
  return fields(a) == fields(b) && same_bytes(a.bytes, b.bytes);
}
inline bool same(const FrameChunk& a, const FrameChunk& b) {
  return fields(a) == fields(b) && same_bytes(a.bytes, b.bytes);
}
inline bool same(const StatusReply& a, const StatusReply& b) {
  return a.has_details == b.has_details && fields(a.status) == fields(b.status) &&
         a.status.quarantined == b.status.quarantined &&
         std::ranges::equal(
             a.status.slaves, b.status.slaves,
             [](const SlaveStatus& x, const SlaveStatus& y) { return fields(x) == fields(y); });
}

}  // namespace tessera::wire
