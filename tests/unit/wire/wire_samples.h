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

  // One message of every type.
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
    s.renderer = static_cast<Renderer>(number(0, 1));
    s.pixel_format = static_cast<PixelFormat>(number(0, 2));
    s.tile_edge_px = static_cast<int>(number(kTileEdgeMinPx, kTileEdgeMaxPx));
    s.samples_per_pixel = static_cast<int>(number(1, kSamplesPerPixelMax));
    s.light_samples = static_cast<int>(number(1, kLightSamplesMax));
    s.seed = small(0, 0xffffffffu);
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
    s.utilisation = real(0, 1);
    s.digest = digest();
    return s;
  }

  StatusReply status_reply() {
    StatusReply reply;
    reply.status.frames_done = any();
    reply.status.has_application = number(0, 1) == 1;
    for (std::uint64_t i = number(0, 5); i > 0; --i) reply.status.slaves.push_back(slave_status());
    reply.status.pace = {static_cast<std::uint32_t>(number(0, kHeartbeatMsMax)),
                         static_cast<std::uint32_t>(number(0, kHeartbeatsMissedLimit)),
                         static_cast<std::uint32_t>(any()),
                         static_cast<std::uint32_t>(any()),
                         0.25,
                         0.5,
                         1.5};
    reply.status.tiles = {any(), any(), any(), any(), any()};
    for (std::uint64_t i = number(0, 3); i > 0; --i) {
      reply.status.quarantined.push_back({text(kNameBytesMax, 1), 12.5,
                                          static_cast<std::uint32_t>(any()),
                                          text(kQuarantineReasonBytesMax, 0)});
    }
    return reply;
  }
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
    return s;
  }

 private:
  std::mt19937_64 random_;
};

inline std::vector<Message> Samples::all() {
  std::vector<Message> m;
  const auto u16 = [this] { return static_cast<std::uint16_t>(number(1, 0xffff)); };
  const std::uint16_t least = static_cast<std::uint16_t>(number(1, 1000));
  m.push_back(Hello{Role::kSlave, least, static_cast<std::uint16_t>(least + number(0, 9)),
                    text(kNameBytesMax), small(1, kWorkersMax), small(1, kIsaMaskAll),
                    text(kBuildIdBytesMax, 0)});
  m.push_back(Hello{static_cast<Role>(number(1, 2)), 1, 1, text(kNameBytesMax), 0, 0, ""});
  m.push_back(Welcome{u16(), number(1, ~0ull), any(), small(1, kHeartbeatMsMax),
                      small(1, kHeartbeatsMissedLimit)});
  m.push_back(Join{u16(), number(1, ~0ull), any()});
  m.push_back(Joined{});
  m.push_back(Refuse{static_cast<RefuseCode>(number(0, 7)), text(kReasonBytesMax, 0)});
  m.push_back(Ping{any()});
  m.push_back(Pong{any()});
  SceneAnnounce announce;
  announce.version = number(1, ~0ull);
  for (std::uint64_t i = number(1, 20); i > 0; --i) {
    announce.digests.push_back(digest());
    announce.sizes.push_back(number(1, kSceneBlockBytesMax));
  }
  m.push_back(announce);
  SceneNeed need;
  need.version = number(1, ~0ull);
  for (std::uint32_t i = small(0, 5); i < 40; i += small(1, 9)) need.blocks.push_back(i);
  m.push_back(need);
  m.push_back(SceneNeed{7, {}});
  m.push_back(SceneChunk{number(1, ~0ull), small(0, kSceneBlocksMax - 1),
                         number(0, kSceneBlockBytesMax - 4096), net::SharedBytes::of(bytes(4096))});
  m.push_back(SceneBuilt{number(1, ~0ull), real(0, 100), number(0, kTrianglesMax), digest()});
  m.push_back(SceneFailed{number(1, ~0ull), text(kReasonBytesMax, 0)});
  m.push_back(SceneRetire{number(1, ~0ull)});
  m.push_back(FrameBegin{any(), number(1, ~0ull), isa(), settings(),
                         small(0, 3) * coding_bit(ByteCoding::kLz4)});
  m.push_back(TileLease{any(), small(0, kTilesPerFrameMax - 1), small(1, 0xffffffffu)});
  m.push_back(FrameEnd{any()});
  m.push_back(TileResult{any(), number(1, ~0ull), small(0, kTilesPerFrameMax - 1),
                         small(1, 0xffffffffu), real(0, 10), real(0, 10), real(0, 10), rays(),
                         bytes(5000), static_cast<ByteCoding>(number(0, 2))});
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
  m.push_back(StatusRequest{});
  m.push_back(status_reply());
  return m;
}

// ---- field by field
// ---------------------------------------------------------------------------------
inline bool same_bytes(const net::SharedBytes& a, const net::SharedBytes& b) {
  return std::ranges::equal(a.bytes, b.bytes);
}
inline auto fields(const Hello& m) {
  return std::tie(m.role, m.version_min, m.version_max, m.name, m.threads, m.isas, m.build_id);
}
inline auto fields(const Welcome& m) {
  return std::tie(m.version, m.session, m.token, m.heartbeat_ms, m.heartbeats_missed_max);
}
inline auto fields(const Join& m) { return std::tie(m.version, m.session, m.token); }
inline auto fields(const Joined&) { return std::tuple<>(); }
inline auto fields(const Refuse& m) { return std::tie(m.code, m.reason); }
inline auto fields(const Ping& m) { return std::tie(m.sent_ns); }
inline auto fields(const Pong& m) { return std::tie(m.sent_ns); }
inline auto fields(const SceneAnnounce& m) { return std::tie(m.version, m.digests, m.sizes); }
inline auto fields(const SceneNeed& m) { return std::tie(m.version, m.blocks); }
inline auto fields(const SceneChunk& m) { return std::tie(m.version, m.block, m.offset); }
inline auto fields(const SceneBuilt& m) {
  return std::tie(m.version, m.build_seconds, m.triangle_count, m.scene);
}
inline auto fields(const SceneFailed& m) { return std::tie(m.version, m.reason); }
inline auto fields(const SceneRetire& m) { return std::tie(m.first_kept); }
inline auto fields(const FrameBegin& m) { return std::tie(m.frame, m.version, m.isa, m.settings); }
inline auto fields(const TileLease& m) { return std::tie(m.frame, m.tile, m.attempt); }
inline auto fields(const FrameEnd& m) { return std::tie(m.frame); }
inline auto fields(const TileResult& m) {
  return std::tie(m.frame, m.version, m.tile, m.attempt, m.seconds, m.starved_seconds,
                  m.held_seconds, m.rays, m.pixels);
}
inline auto fields(const TileReturned& m) { return std::tie(m.frame, m.tile, m.attempt); }
inline auto fields(const Goodbye& m) { return std::tie(m.reason); }
inline auto fields(const FrameSubmit& m) { return std::tie(m.frame, m.version, m.settings); }
inline auto fields(const FrameCancel& m) { return std::tie(m.frame); }
inline auto fields(const FrameChunk& m) { return std::tie(m.frame, m.offset); }
inline auto fields(const StatusRequest&) { return std::tuple<>(); }
inline auto fields(const FrameStats& s) {
  return std::tie(s.frame, s.seconds, s.scene_version, s.isa, s.is_mixed, s.slave_count,
                  s.tile_count, s.tile_edge_px, s.tiles_reissued, s.tiles_rejected, s.rays,
                  s.bytes_to_slaves, s.bytes_from_slaves, s.build_seconds, s.utilisation,
                  s.tiles_duplicated, s.tiles_faulty, s.pixels_faulty, s.render_seconds,
                  s.prefetch_min, s.prefetch_max, s.completed_at_seconds, s.digest);
}
inline auto fields(const FrameDone& m) {
  return std::tuple_cat(fields(m.stats), std::tie(m.error, m.tile_slave));
}
inline auto fields(const SlaveStatus& s) {
  return std::tie(s.name, s.threads, s.isa, s.tiles_in_flight, s.tiles_done, s.utilisation,
                  s.rtt_seconds, s.scene_version, s.tile_port, s.scene_port);
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
  return a.status.frames_done == b.status.frames_done &&
         a.status.has_application == b.status.has_application && a.status.pace == b.status.pace &&
         a.status.tiles == b.status.tiles && a.status.quarantined == b.status.quarantined &&
         std::ranges::equal(
             a.status.slaves, b.status.slaves,
             [](const SlaveStatus& x, const SlaveStatus& y) { return fields(x) == fields(y); });
}

}  // namespace tessera::wire
