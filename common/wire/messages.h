// SPDX-License-Identifier: Apache-2.0
// Every message of the protocol as plain values. codec.h turns them into records and back; what
// comes out of decode() is validated, so that the state machines trust ranges and lengths (not
// meaning: whether a tile was asked for is the ledger's to say). The protocol itself:
// proto/PROTOCOL.md.
//
// Threads. Plain values.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "common/base/digest.h"
#include "common/base/ids.h"
#include "common/base/isa.h"
#include "common/frame/frame_settings.h"
#include "common/frame/frame_stats.h"
#include "common/net/record.h"
#include "common/scene/block_chunks.h"
#include "common/wire/byte_coding.h"

namespace tessera::wire {

inline constexpr std::uint16_t kProtocolVersionMin = 1;
inline constexpr std::uint16_t kProtocolVersionMax = 1;

enum class Role : std::uint8_t { kSlave = 0, kApp = 1, kStatus = 2 };

// ---- handshake, both directions named from the master's side ----

// First record on a slave's tile connection, an application's or a status client's connection.
struct Hello {
  Role role = Role::kSlave;
  std::uint16_t version_min = kProtocolVersionMin, version_max = kProtocolVersionMax;
  std::string name;                // 1..kNameBytesMax printable bytes
  std::uint32_t threads = 0;       // slave: render threads, 1..kWorkersMax
  IsaMask isas = 0;                // slave: what it may use
  std::string build_id;            // project version, for the log
  std::uint64_t memory_bytes = 0;  // slave: how much it may take in all; 0: unknown
  std::uint16_t relay_port = 0;    // slave: where it listens for slaves that it feeds; 0: nowhere
  std::uint64_t relay_token = 0;   // slave: what those must say
  std::uint64_t instance = 0;      // slave: random number of its process; 0: it does not say
};
// Answer to Hello: the session exists. A slave now opens its scene connection with Join.
struct Welcome {
  std::uint16_t version = 0;
  SessionId session = 0;
  std::uint64_t token = 0;  // random; it proves that the scene connection belongs to the session
  std::uint32_t heartbeat_ms = 0, heartbeats_missed_max = 0;
  bool issues_certificates = false;  // CertificateRequest is answered
};
// First record on a slave's scene connection. Answered by Joined.
struct Join {
  std::uint16_t version = 0;
  SessionId session = 0;
  std::uint64_t token = 0;
};
struct Joined {};
enum class RefuseCode : std::uint8_t {
  kVersion = 0,
  kRole = 1,
  kName = 2,
  kIsa = 3,
  kBusy = 4,
  kSession = 5,
  kFull = 6,
  kProtocol = 7,
};
// Last record before the sender closes, with the reason. Any direction, any connection.
struct Refuse {
  RefuseCode code = RefuseCode::kProtocol;
  std::string reason;  // one line for a person
};
// Sent when nothing else was sent for heartbeat_ms; echoed as Pong at once, which gives the round
// trip.
struct Ping {
  std::uint64_t sent_ns = 0;
};
struct Pong {
  std::uint64_t sent_ns = 0;
  std::uint64_t answered_ns = 0;  // of the answering peer's own clock; 0: not given
};

// ---- scene: sender -> holder (master -> slave on the scene connection; app -> master) ----
struct SceneAnnounce {
  SceneVersion version = 0;
  std::vector<Digest> digests;       // payload: 32 bytes each; block 0 is the root
  std::vector<std::uint64_t> sizes;  // payload: 8 bytes each
  // Memory that a holder will take for the spatial index, as the sender estimates it
  // (scene_footprint.h).
  std::uint64_t index_bytes = 0;
  // The blocks are those of the announcement before this one on the connection, but for those at
  // `places`, whose digests and sizes follow: none where the same scene is shown at another time.
  bool is_again = false;
  std::vector<std::uint32_t> places;  // payload: 4 bytes each, ascending; of is_again alone
  double time_seconds = 0;            // at which the scene is shown
};
struct SceneNeed {  // holder -> sender: indices of blocks it lacks, ascending (payload: u32 each)
  SceneVersion version = 0;
  std::vector<std::uint32_t> blocks;
  ByteCodingMask codings = kByteCodingsNone;  // that the holder decodes
};
struct SceneChunkList {  // sender -> holder: the digests of a block of more than one chunk
  SceneVersion version = 0;
  std::uint32_t block = 0;
  ChunkDigests chunks;  // payload: 32 bytes each
};
struct SceneChunkNeed {  // holder -> sender, or -> a slave that relays: chunks that it lacks
  SceneVersion version = 0;
  std::uint32_t block = 0;
  std::vector<bool> chunks;  // payload: a bit each, lowest first; true: lacking
};
struct SceneChunk {  // one chunk of block `block` of `version`; in any order
  SceneVersion version = 0;
  std::uint32_t block = 0;
  std::uint64_t offset = 0;  // a multiple of kSceneChunkBytes
  net::SharedBytes bytes;    // payload, 1..kSceneChunkBytes; coded, it must decode to the chunk
  ByteCoding coding = ByteCoding::kNone;
};
struct SceneBuilt {  // slave -> master: frames of this version may be leased (master -> app:
                     // committed)
  SceneVersion version = 0;
  double build_seconds = 0;
  std::uint64_t triangle_count = 0;  // and patches
  Digest scene{};  // EncodedScene::digest() of what was built (master -> app: zeros)
  // Of these, those put into structures for it; 0: the geometry is that of the version before.
  std::uint64_t built_primitives = 0;
};
struct SceneFailed {
  SceneVersion version = 0;
  std::string reason;
  // Not 0: the holder lacks memory for the scene, which needs `needed_bytes`.
  std::uint64_t needed_bytes = 0, free_bytes = 0;
};
struct SceneRetire {  // older versions are not needed any more
  SceneVersion first_kept = 0;
  bool keeps_newest = false;  // the last built scene is kept until the next version is built
};

// ---- relay: slaves feed slaves
// Master -> slave on the scene connection: the slave asks `feeder` for the chunks of `version` that
// it lacks.
struct RelayFrom {
  SceneVersion version = 0;
  SessionId feeder = 0;     // 0: the slave asks the master again; the other fields are then empty
  std::string host;         // 1..kNameBytesMax printable bytes
  std::uint16_t port = 0;   // not 0
  std::uint64_t token = 0;  // the feeder's own
};
enum class RelayFault : std::uint8_t {
  kUnreachable = 0,
  kGone = 1,     // it closed, or has nothing of the version
  kAltered = 2,  // it sent bytes that do not have their digest, or were not asked for
};
struct RelayFailed {  // slave -> master: it needs another feeder
  SceneVersion version = 0;
  SessionId feeder = 0;
  RelayFault fault = RelayFault::kGone;
  std::string reason;  // one line for a person
};
struct SceneProgress {  // slave -> master: how many bytes of the version are here and checked
  SceneVersion version = 0;
  std::uint64_t bytes = 0;
};
// A slave asks for a new certificate; only of a master whose Welcome says that it issues some.
struct CertificateRequest {
  std::vector<std::byte> der;  // PKCS#10, signed by the new key
};
struct CertificateGrant {
  std::vector<std::byte> der;  // X.509; empty where it is refused
  std::string reason;          // one line for a person; empty where it is granted
};
// First record of one slave to another; SceneChunkNeed follows, SceneChunk comes back.
struct RelayJoin {
  std::uint64_t token = 0;
  ByteCodingMask codings = kByteCodingsNone;  // that the sender decodes
};

// ---- tiles: master -> slave on the tile connection ----
struct FrameBegin {
  FrameId frame = 0;
  SceneVersion version = 0;
  Isa isa = Isa::kScalar;
  FrameSettings settings;
  // Codings in which the master lets pixels travel besides plainly; a master that names none wants
  // them plain.
  ByteCodingMask pixel_codings = kByteCodingsNone;
};
struct TileLease {
  FrameId frame = 0;
  TileIndex tile = 0;
  Attempt attempt = 0;
};
struct FrameEnd {
  FrameId frame = 0;
};  // finished or cancelled: drop its tiles
// slave -> master
struct TileResult {
  FrameId frame = 0;
  SceneVersion version = 0;
  TileIndex tile = 0;
  Attempt attempt = 0;
  double seconds = 0;          // render time
  double starved_seconds = 0;  // worker time lost on an empty queue since the last result
  double held_seconds = 0;     // from the lease's arrival to this result's departure
  RayCounts rays;
  std::uint64_t began_ns = 0;             // of the slave's own clock; 0: not given
  std::uint32_t worker = 0;               // which of its render threads, below Hello's threads
  std::vector<std::byte> pixels;          // payload, in the frame's format
  ByteCoding coding = ByteCoding::kNone;  // of the payload: pixel_coding.h
};
struct TileReturned {
  FrameId frame = 0;
  TileIndex tile = 0;
  Attempt attempt = 0;
};  // handed back, unrendered
struct Goodbye {
  std::string reason;
};  // orderly leave, either side; nothing follows

// ---- application ----
struct FrameSubmit {
  FrameId frame = 0;
  SceneVersion version = 0;
  FrameSettings settings;
};
struct FrameCancel {
  FrameId frame = 0;
};
struct FrameChunk {  // master -> app, in order
  FrameId frame = 0;
  std::uint64_t offset = 0;
  net::SharedBytes bytes;
};
struct FrameDone {  // after the last chunk, or alone when the frame failed
  FrameStats stats;
  std::string error;                      // empty: delivered
  bool is_final = false;                  // with an error: trying again does not help
  std::vector<std::uint16_t> tile_slave;  // payload: u16 each
};
struct StatusRequest {
  bool wants_details = true;  // false from older clients, which know the short entries only
  bool wants_events = false;  // of the master's log
};
struct StatusReply {
  ClusterStatus status;
  bool has_details = true;  // of each slave; false: the short entries of older peers
};

using Message = std::variant<Hello, Welcome, Join, Joined, Refuse, Ping, Pong, SceneAnnounce,
                             SceneNeed, SceneChunkList, SceneChunkNeed, SceneChunk, SceneBuilt,
                             SceneFailed, SceneRetire, RelayFrom, RelayFailed, SceneProgress,
                             RelayJoin, CertificateRequest, CertificateGrant, FrameBegin, TileLease,
                             FrameEnd, TileResult, TileReturned, Goodbye, FrameSubmit, FrameCancel,
                             FrameChunk, FrameDone, StatusRequest, StatusReply>;

}  // namespace tessera::wire
