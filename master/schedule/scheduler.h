// Decides which slave renders which tile of which frame. Pure: events and `now` go in, actions come
// out, in the order in which they are to be done. The product and tests/sim drive the same object.
//
// After Benthin 2006, 8.3: dynamic balancing (one result brings one new tile), prefetching (tiles
// queued on each slave in advance), two frames in flight, tiles only of scene versions that the
// slave has built. Beyond it: slaves come and go at any moment, and overdue tiles are leased twice.
//
// Invariants. (1) At most frames_in_flight frames are leased at once, the oldest first. (2)
// kFrameComplete and kFrameFailed come in the order of submission, once each. (3) A slave holds at
// most threads * (prefetch_per_thread + 1) tiles. (4) Every loop is bounded by slaves times tiles.
#pragma once

#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "master/schedule/frame_ledger.h"

namespace tessera::master {

struct SchedulerOptions {
  int prefetch_per_thread = 3;
  int frames_in_flight = 2;
};

enum class ActionKind { kBeginFrame, kLease, kEndFrame, kFrameComplete, kFrameFailed };

struct Action {
  ActionKind kind = ActionKind::kLease;
  SessionId session = 0;  // kBeginFrame, kLease, kEndFrame
  FrameId frame = 0;
  TileAssignment tile;        // kLease
  bool is_cancelled = false;  // kFrameFailed: on request
  std::string reason;         // kFrameFailed
};
using Actions = std::vector<Action>;

class Scheduler {
 public:
  explicit Scheduler(const SchedulerOptions& options) : options_(options) {}

  // Nothing is leased before (the session's instruction set must be known first).
  Actions start(TimePoint now);
  bool is_started() const { return is_started_; }

  // Requires: session unknown so far; threads >= 1.
  void slave_joined(SessionId session, std::uint32_t threads);
  Actions slave_lost(SessionId session, TimePoint now);
  Actions scene_built(SessionId session, SceneVersion version, TimePoint now);
  Actions scene_failed(SessionId session, SceneVersion version, const std::string& reason,
                       TimePoint now);

  // Requires: frame numbers count up.
  Actions submit_frame(FrameId frame, SceneVersion version, TileIndex tile_count, TimePoint now);
  Actions cancel_frame(FrameId frame, TimePoint now);
  // A frame that cannot be begun; it fails in its turn. Requires: as submit_frame().
  Actions refuse_frame(FrameId frame, std::string reason);
  // No frame needs older versions any more, nor will.
  void retire_scenes(SceneVersion first_kept);

  // `actions` gets what follows from it. Violations change nothing.
  ResultVerdict result(SessionId session, FrameId frame, SceneVersion version, TileIndex tile,
                       Attempt attempt, TimePoint now, Actions& actions);
  Actions tile_returned(SessionId session, FrameId frame, TileIndex tile, Attempt attempt,
                        TimePoint now);

  // Call every 50 to 100 ms: overdue tiles are leased again, tiles handed back to anybody.
  Actions tick(TimePoint now);

  std::uint32_t tiles_in_flight(SessionId session) const;
  // Null when the frame is not known (any more).
  const FrameLedger* ledger(FrameId frame) const;
  // Over all frames, the ended ones too.
  LedgerCounts counts() const;
  // Smallest scene version that an unfinished frame needs; `none` when there is none.
  SceneVersion oldest_version_needed(SceneVersion none) const;

 private:
  struct Slave {
    std::uint32_t threads = 1;
    std::uint32_t in_flight = 0;
    std::set<SceneVersion> built;
    std::map<SceneVersion, std::string> failed;
    std::set<FrameId> begun;
    TimePoint rests_until{};  // it has handed a tile back: it is leaving, or cannot render it
  };
  enum class FrameState { kOpen, kComplete, kFailed, kCancelled };
  struct Frame {
    FrameId id = 0;
    FrameState state = FrameState::kOpen;
    std::string reason;
    FrameLedger ledger;
    std::map<SessionId, std::uint32_t> held;  // leases outstanding, by slave
  };

  Frame* find(FrameId frame);
  std::size_t active_count() const;
  void fill_all(TimePoint now, Actions& actions);
  bool lease_one(SessionId session, Slave& slave, TimePoint now, Actions& actions);
  void issue(SessionId session, Slave& slave, Frame& frame, TileAssignment tile, Actions& actions);
  void release(Frame& frame, SessionId session);
  void end_frame(Frame& frame, FrameState state, std::string reason, Actions& actions);
  void deliver(Actions& actions);
  void fail_hopeless(Actions& actions);

  const SchedulerOptions options_;
  bool is_started_ = false;
  std::map<SessionId, Slave> slaves_;
  std::deque<Frame> frames_;  // in order of submission; ended ones leave from the front
  FrameId next_frame_ = 0;    // above every frame ever submitted
  LedgerCounts ended_counts_;
  double turnaround_seconds_ = 0;  // moving average, lease to result
  std::map<std::pair<FrameId, TileIndex>, TimePoint> leased_at_;
};

}  // namespace tessera::master
