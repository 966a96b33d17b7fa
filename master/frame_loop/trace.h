// SPDX-License-Identifier: Apache-2.0
// What a trace of the cluster holds: spans of frames, of builds and of the ways of scenes to slaves
// by the master's clock, spans of tiles by their slaves' clocks, and how far those are apart.
// write_trace() makes a file of it in the "Trace Event Format" (JSON object form), which Perfetto
// (ui.perfetto.dev) and chrome://tracing open.
//
// Threads. TraceRecorder: io thread. Trace: a plain value, handed over whole.
//
// Invariants. (1) At most kTilesMax tiles and kFramesMax frames and builds are kept; the oldest
// leaves, and is counted. (2) In the file, spans of one row do not overlap, and times of all rows
// are the master's, each within its slave's stated error.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/base/limits.h"
#include "common/base/status.h"
#include "master/cluster/clock_offset.h"

namespace tessera::master {

struct TracedSlave {
  std::string name;
  std::uint32_t threads = 0;
  std::optional<ClockEstimate> clock;  // without one, its tiles cannot be placed, and are left out
};

struct TracedTile {
  SessionId session = 0;
  FrameId frame = 0;
  std::uint32_t tile = 0, attempt = 0, worker = 0;
  TimePoint leased, received;  // master's clock
  std::uint64_t began_ns = 0;  // slave's clock
  double render_seconds = 0;
  bool is_accepted = false;
};

struct TracedFrame {
  FrameId frame = 0;
  SceneVersion version = 0;
  TimePoint begin, end;
  const char* outcome = "";  // "done", "failed", "cancelled"
};

// A scene that a slave has built.
struct TracedBuild {
  SessionId session = 0;
  SceneVersion version = 0;
  TimePoint told;  // by the master's clock: later than its end by the message's way
  double seconds = 0;
  std::uint64_t built_primitives = 0;
  std::optional<TimePoint> offered = {};  // since then the scene was there for the slave
};

struct Trace {
  TimePoint start;                          // time 0 of the file
  std::map<SessionId, TracedSlave> slaves;  // also those that are gone, while their tiles are kept
  std::deque<TracedTile> tiles;
  std::deque<TracedFrame> frames;
  std::deque<TracedBuild> builds;
  std::uint64_t tiles_dropped = 0, frames_dropped = 0, builds_dropped = 0;
};

class TraceRecorder {
 public:
  // 72 bytes each in memory, about 350 in the file.
  static constexpr std::size_t kTilesMax = 100'000;
  static constexpr std::size_t kFramesMax = 10'000;
  static constexpr std::size_t kSlavesMax = 2 * kConnectionsMax;  // gone ones, too

  explicit TraceRecorder(TimePoint now) { trace_.start = now; }

  void slave_joined(SessionId session, const std::string& name, std::uint32_t threads);
  void leased(SessionId session, FrameId frame, std::uint32_t tile, std::uint32_t attempt,
              TimePoint now);
  // The slave's leases of that frame, or of all frames, are over without a result.
  void frame_ended(SessionId session, FrameId frame);
  void slave_lost(SessionId session);
  // Keeps the tile if it answers a lease told of before. `clock`: the slave's as known now; the
  // estimate with the smallest error wins.
  void answered(TracedTile tile, const std::optional<ClockEstimate>& clock);
  void frame_over(const TracedFrame& frame);
  void built(const TracedBuild& build);

  // Hands over what is there; nothing should follow.
  Trace take() { return std::move(trace_); }

 private:
  using LeaseKey = std::tuple<SessionId, FrameId, std::uint32_t, std::uint32_t>;

  void forget_slaves();

  Trace trace_;
  std::set<SessionId> present_;
  std::map<LeaseKey, TimePoint> leases_;  // outstanding
};

// The file's text.
std::string trace_json(const Trace& trace);

// Returns: kUnavailable naming file and reason.
Status write_trace(const Trace& trace, const std::string& path);

}  // namespace tessera::master
