// SPDX-License-Identifier: Apache-2.0
// What one frame cost; the source of a --stats line and of the overlay.
// Threads. Plain values. Master and application hold the same ones: what the wire carries is all
// there is.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/api.h"
#include "common/base/digest.h"
#include "common/base/event_memory.h"
#include "common/base/ids.h"
#include "common/base/isa.h"

namespace tessera {

// Rays traced for a tile or frame.
struct RayCounts {
  std::uint64_t primary = 0, shadow = 0, secondary = 0;
  RayCounts& operator+=(const RayCounts& o) {
    primary += o.primary;
    shadow += o.shadow;
    secondary += o.secondary;
    return *this;
  }
  bool operator==(const RayCounts&) const = default;
};

// What scenes cost between frames.
struct SceneCost {
  std::uint64_t built_primitives = 0;  // put into structures by the slave that built most
  // Time in which frames were open and slaves there, but none in work for want of a scene.
  double wait_seconds = 0;
  std::uint64_t bytes = 0;  // sent by the master on the connections that carry scenes
  SceneCost& operator+=(const SceneCost& o) {
    built_primitives += o.built_primitives;
    wait_seconds += o.wait_seconds;
    bytes += o.bytes;
    return *this;
  }
  bool operator==(const SceneCost&) const = default;
};

struct FrameStats {
  FrameId frame = 0;
  double seconds = 0;               // first lease to last result
  double completed_at_seconds = 0;  // since the master started
  SceneVersion scene_version = 0;
  Isa isa = Isa::kScalar;
  bool is_mixed = false;  // slaves of several instruction sets took part
  std::uint32_t slave_count = 0;
  std::uint32_t tile_count = 0;
  std::uint32_t tile_edge_px = 0;
  std::uint32_t tiles_reissued = 0;
  std::uint32_t tiles_rejected = 0;
  std::uint32_t tiles_faulty = 0;      // results with NaN, infinite or negative pixels
  std::uint64_t pixels_faulty = 0;     // pixels of the frame painted in the error colour
  std::uint32_t tiles_duplicated = 0;  // leased a second time to end the frame sooner
  RayCounts rays;
  std::uint64_t bytes_to_slaves = 0;
  std::uint64_t bytes_from_slaves = 0;
  double build_seconds = 0;   // slowest slave's build of this scene version
  SceneCost scene_cost;       // since the frame that was completed before
  double utilisation = 0;     // 1 - starved / available worker time
  double render_seconds = 0;  // on render threads, over all accepted tiles
  // Tiles that a slave may hold, the ones in work included: least and most over the slaves when the
  // frame ended.
  std::uint32_t prefetch_min = 0, prefetch_max = 0;
  Digest digest;  // of the pixels in the frame's format, row by row from the top
};

// Every lease ends in one of three ways: issued == accepted + rejected + abandoned + in_flight, at
// every moment.
struct TileAccounts {
  std::uint64_t issued = 0, accepted = 0, rejected = 0, abandoned = 0, in_flight = 0;
  bool operator==(const TileAccounts&) const = default;
};

enum class SlaveState : std::uint8_t {
  kWaiting = 0,  // the slave has not built the newest scene
  kReady = 1,    // the slave gets tiles when there are any
  kStalled = 2,  // the slave holds tiles and returns none: it gets one at a time
};
TESSERA_API std::string_view slave_state_name(SlaveState state);

// State of one slave, for a person.
struct SlaveStatus {
  std::string name;
  std::uint32_t threads = 0;
  Isa isa = Isa::kScalar;  // widest that the slave has
  std::uint32_t tiles_in_flight = 0;
  std::uint64_t tiles_done = 0;
  double utilisation = 0;  // share of its threads' time spent rendering, last second
  double rtt_seconds = 0;
  SceneVersion scene_version = 0;               // newest built
  std::uint16_t tile_port = 0, scene_port = 0;  // the slave's ports, for status
  SlaveState state = SlaveState::kReady;
  std::uint16_t ordinal = 0;         // the slave's number in FrameImage::tile_slave
  std::uint32_t prefetch_depth = 0;  // tiles that it may hold at present beyond those in work
  double tiles_per_second = 0;       // accepted ones, last second
  double tile_seconds = 0;           // render time of a tile, moving average
  TileAccounts tiles;                // of this session
  std::uint64_t queue_bytes = 0;     // waiting in the master for its two links
  std::uint64_t bytes_sent = 0, bytes_received = 0;  // by the master, this session
};

// Settings of the cluster, and measurements of the slaves that are connected, from which bounds on
// the cluster's reaction to faults are computed.
struct ClusterPace {
  std::uint32_t heartbeat_ms = 0;  // the longest in use
  std::uint32_t heartbeats_missed_max = 0;
  std::uint32_t handshake_ms = 0;      // from accept to a complete handshake
  std::uint32_t reconnect_max_ms = 0;  // a slave's greatest pause, before its random factor
  double rtt_seconds_max = 0;
  double tile_seconds_median = 0;  // of the last tiles of all slaves
  double tile_seconds_p95 = 0;     // of the slave whose 95th percentile is greatest
  bool operator==(const ClusterPace&) const = default;
};

// A slave that is not let in for a while.
struct QuarantinedSlave {
  std::string name;         // of its certificate, else the one it gives
  double seconds = 0;       // until it is let in again
  std::uint32_t times = 0;  // how often it has been held back so far
  std::string reason;
  bool operator==(const QuarantinedSlave&) const = default;
};

struct ClusterStatus {
  std::vector<SlaveStatus> slaves;
  std::uint64_t frames_done = 0;
  bool has_application = false;
  ClusterPace pace;
  TileAccounts tiles;  // over all frames, of slaves that are gone, too
  std::uint64_t frames_failed = 0, frames_cancelled = 0;
  std::uint32_t frames_open = 0;  // submitted, and not yet given back
  std::uint64_t tiles_reissued = 0;
  std::uint64_t slaves_lost = 0;
  std::vector<QuarantinedSlave> quarantined;
  std::string alone_reason;  // why no slave is here, where it is the master's own link; else empty
  // Of the master's log, where they were asked for.
  std::vector<PastEvent> events;  // oldest first
  std::vector<SuppressedLines> suppressed;
};

}  // namespace tessera
