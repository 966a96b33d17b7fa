// SPDX-License-Identifier: Apache-2.0
// Decides which slave renders which tile of which frame. Pure: events and `now` go in, actions come
// out, in the order in which they are to be done. The product and tests/sim drive the same object.
//
// After Benthin 2006, 8.3: dynamic balancing (one result brings one new tile), prefetching (tiles
// queued on each slave in advance), two frames in flight, tiles only of scene versions that the
// slave has built. Beyond it: the depth of the queues follows each slave's measured pace
// (slave_pace.h); the last tiles of a frame go to whoever will have them back first, and are leased
// twice where that shortens the frame; slaves come and go at any moment; a share of the tiles is
// rendered twice and compared. Tiles that a slave was lost with go to slaves that have earned it,
// so that no slave, however bad, fails a frame while a good one is there (scheduler_losses.cpp).
//
// Invariants. (1) At most frames_in_flight frames are leased at once, the oldest first. (2)
// kFrameComplete and kFrameFailed come in the order of submission, once each. (3) A slave holds at
// most SlavePace::depth() tiles, one late tile more for each thread, and those it was lent when its
// depth was greater; one that was lost before, at most one more than it has brought since; one that
// has stalled gets a tile only when it holds none. (4) Every loop is bounded by slaves times tiles.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "master/schedule/audit_choice.h"
#include "master/schedule/departed_slaves.h"
#include "master/schedule/duplication_budget.h"
#include "master/schedule/frame_ledger.h"
#include "master/schedule/slave_history.h"
#include "master/schedule/slave_identity.h"
#include "master/schedule/slave_pace.h"

namespace tessera::master {

struct SchedulerOptions {
  int prefetch_per_thread = SlavePace::kPrefetchAuto;
  int frames_in_flight = 2;
  bool is_static = false;  // each slave has its fixed tiles: for measuring what balancing is worth
  AuditOptions audit{};    // tiles that two slaves render, and whose pixels are compared
};

enum class ActionKind {
  kBeginFrame,
  kLease,
  kEndFrame,
  kExpel,    // an audit has found that this slave's pixels are wrong; it may be gone since
  kSuspect,  // its pixels were refused, and another slave had no cause for that; likewise
  kStalled,  // it holds tiles and returns none, though its link may live: once for each stall
  kFrameComplete,
  kFrameFailed
};

struct Action {
  ActionKind kind = ActionKind::kLease;
  SessionId session = 0;  // all but the last two; kStalled has no frame; kExpel, kSuspect: its then
  FrameId frame = 0;
  TileAssignment tile;        // kLease; kExpel, kSuspect: the tile that was wrong
  bool is_cancelled = false;  // kFrameFailed: on request
  std::string reason;         // kFrameFailed, kExpel, kSuspect, kStalled
  bool is_final = false;      // kFrameFailed: trying again would do harm, or nothing
  std::string slave{};        // kExpel, kSuspect: SlaveIdentity::id()
};
using Actions = std::vector<Action>;

// What a slave says of one tile.
struct TileReport {
  FrameId frame = 0;
  SceneVersion version = 0;
  TileIndex tile = 0;
  Attempt attempt = 0;
  double render_seconds = 0;   // on a render thread
  double held_seconds = 0;     // from the lease's arrival to the result's departure
  double starved_seconds = 0;  // of its render threads, since its last result
  std::uint64_t pixels = 0;    // digest; of audited tiles only
  bool is_faulty = false;      // some of its pixels cannot be light (NaN, infinite, negative)
};

class Scheduler {
 public:
  explicit Scheduler(const SchedulerOptions& options) : options_(options), audits_(options.audit) {}

  // Nothing is leased before this call (the session's instruction set must be known first).
  Actions start(TimePoint now);
  bool is_started() const { return is_started_; }

  // Requires: session unknown so far; threads >= 1.
  void slave_joined(SessionId session, SlaveIdentity slave, std::uint32_t threads, TimePoint now);
  Actions slave_lost(SessionId session, TimePoint now, SlaveEnd how = SlaveEnd::kLost);
  Actions scene_built(SessionId session, SceneVersion version, TimePoint now);
  Actions scene_failed(SessionId session, SceneVersion version, const std::string& reason,
                       TimePoint now);
  // Takes the round trip of heartbeats, which matters until tiles have shown it.
  void round_trip_measured(SessionId session, double seconds);

  // `order`: every tile of the frame once. Requires: frame numbers count up.
  Actions submit_frame(FrameId frame, SceneVersion version, std::vector<TileIndex> order,
                       TimePoint now);
  Actions cancel_frame(FrameId frame, TimePoint now);
  Actions fail_frame(FrameId frame, std::string reason, TimePoint now);
  // Takes a frame that cannot be begun, or was cancelled before it could be; it fails in its turn,
  // and is not worth another try. Requires: as submit_frame().
  Actions refuse_frame(FrameId frame, std::string reason, bool is_cancelled = false);
  // No frame needs older versions any more, and none will.
  void retire_scenes(SceneVersion first_kept);

  // `actions` gets what follows from the result. Violations lease and end nothing.
  ResultVerdict result(SessionId session, const TileReport& report, TimePoint now,
                       Actions& actions);
  Actions tile_returned(SessionId session, FrameId frame, TileIndex tile, Attempt attempt,
                        TimePoint now);

  // Call every 10 to 50 ms while frames are open: late tiles are leased again, tiles handed back
  // to anybody.
  Actions tick(TimePoint now);

  bool has_open_frames() const { return !frames_.empty(); }
  std::uint32_t tiles_in_flight(SessionId session) const;
  bool is_stalled(SessionId session) const;
  // Null when there is no such slave.
  const SlavePace* pace(SessionId session) const;
  // Null when the frame is not known (any more).
  const FrameLedger* ledger(FrameId frame) const;
  // Whether another slave's pixels of the tile may take the place of those that were accepted.
  bool is_under_audit(FrameId frame, TileIndex tile) const;
  // Sums over all frames, the ended ones too.
  LedgerCounts counts() const;
  // Smallest scene version that an unfinished frame needs; `none` when there is none.
  SceneVersion oldest_version_needed(SceneVersion none) const;

 private:
  struct Slave {
    SlaveIdentity is;
    SlavePace pace;
    std::uint32_t debt_tiles = 0;  // SlaveHistory::Past
    bool was_lost = false;         // within living memory
    bool has_brought = false;      // a tile, in this session or in one before it
    std::uint32_t brought = 0;     // results of this session that answered a lease
    std::uint32_t in_flight = 0;
    std::set<SceneVersion> built{};
    std::map<SceneVersion, std::string> failed{};
    std::set<FrameId> begun{};
    TimePoint rests_until{};  // after a tile was handed back: the slave leaves or cannot render it
    TimePoint last_heard{};   // the last result, or the first lease after the slave had none
    bool was_dry = true;      // since the last result there was a moment without a tile for it
    Duration silence{};       // time with tiles and without a result, since the last one
    TimePoint watched{};      // when silence was brought up to date
    bool is_stalled = false;  // silent for so long that it gets one tile at a time
    TimePoint probe_at{};     // when a stalled slave may have a tile again
  };
  // Whom tiles that slaves were lost with go to, the best first.
  enum class Trust { kProven, kEarned, kNew, kDoubtful };
  static constexpr std::size_t kTrusts = 4;
  enum class FrameState { kOpen, kComplete, kFailed, kCancelled };
  struct Frame {
    FrameId id = 0;
    FrameState state = FrameState::kOpen;
    std::string reason;
    FrameLedger ledger;
    std::map<SessionId, std::uint32_t> held;  // leases outstanding, by slave
    // Slaves that have its scene, by trust; counted only while some of its tiles are lost ones.
    std::array<std::uint32_t, kTrusts> able{};
    bool is_final = false;  // its failure
    // Of tiles with more leases than they may need: who has held one since then without
    // rendering it, by SlaveIdentity::id().
    std::map<TileIndex, std::set<std::string>> useless_to{};
  };
  using SlaveEntry = std::pair<const SessionId, Slave>;

  // scheduler.cpp
  Frame* find(FrameId frame);
  std::size_t active_count() const;
  void release(Frame& frame, SessionId session);
  void count_pace(const SlavePace& pace, int sign);
  void end_frame(Frame& frame, FrameState state, std::string reason, Actions& actions);
  void deliver(Actions& actions);
  void fail_hopeless(TimePoint now, Actions& actions);
  void learn(Slave& slave, const TileReport& report, TimePoint leased_at, TimePoint now);
  std::string name_of(SessionId session) const;
  std::string id_of(const ResultAuthor& author) const;

  // scheduler_audits.cpp
  void settle_audit(Frame& frame, SessionId session, TileIndex tile, const LedgerAnswer& answer,
                    Actions& actions);
  void waive_audits(Frame& frame, Actions& actions);
  void waive_refusals(Frame& frame);
  void audit_without(const std::set<SessionId>& silent, Actions& actions);
  std::vector<SessionId> auditors(const Frame& frame) const;
  bool has_auditors(const Frame& frame, std::size_t least) const;
  bool may_audit(const Slave& slave, const Frame& frame) const;

  // scheduler_losses.cpp
  static Trust trust_in(const Slave& slave);
  void count_able(Frame& frame);
  bool may_have_lost_tile(const Frame& frame, const SlaveEntry& entry, TileIndex tile,
                          TimePoint now) const;
  FrameLedger::LostTileFilter lost_tiles_for(const Frame& frame, const SlaveEntry& entry,
                                             TimePoint now) const;
  void fail_lost_tiles(TimePoint now, Actions& actions);
  bool is_anybody_left(const Frame& frame, TileIndex tile, Trust least) const;
  bool is_given_up(const Frame& frame, TileIndex tile, TimePoint now) const;
  bool is_useless_to_all(Frame& frame, TileIndex tile, const SlaveIdentity& slave) const;
  void heard(Slave& slave, TimePoint now);
  void watch_for_stalls(TimePoint now, Actions& actions);
  static std::uint32_t allowance(const Slave& slave);

  // scheduler_leasing.cpp
  bool can_take(const Slave& slave, const Frame& frame, TimePoint now) const;
  bool has_room(const Slave& slave, TimePoint now) const;
  bool has_late_room(const Slave& slave, TimePoint now) const;
  std::size_t able_count(const Frame& frame) const;
  std::uint32_t tiles_ahead(std::size_t frame, const SlaveEntry& entry) const;
  bool is_in_time(std::size_t frame, const SlaveEntry& entry, TimePoint now) const;
  void fill(SlaveEntry& entry, TimePoint now, Actions& actions);
  void fill_all(TimePoint now, Actions& actions);
  bool lease_one(SlaveEntry& entry, TimePoint now, Actions& actions);
  void spread(std::size_t frame, TimePoint now, Actions& actions);
  bool lease_static(Frame& frame, SlaveEntry& entry, TimePoint now, Actions& actions);
  double back_seconds(const Slave& slave, std::uint32_t ahead, TimePoint now) const;
  Duration silence_allowed(const Slave& slave) const;
  bool is_silent(const Slave& slave, TimePoint now) const;
  TimePoint due_at(const Slave& slave, TimePoint now) const;
  void lease_next(SlaveEntry& entry, Frame& frame, TimePoint now, Actions& actions);
  void issue(SlaveEntry& entry, Frame& frame, TileAssignment tile, TimePoint now, Actions& actions);
  void duplicate_late_tiles(Frame& frame, TimePoint now, Actions& actions);
  SlaveEntry* fastest_for(const Frame& frame, const TileLeaseView& lease, TimePoint now,
                          double& best_seconds);

  // Time of a tile until one is measured; any value but 0 makes slaves with few tiles look better.
  static constexpr double kTileSecondsGuess = 0.010;

  const SchedulerOptions options_;
  bool is_started_ = false;
  std::map<SessionId, Slave> slaves_;
  DepartedSlaves departed_;
  SlaveHistory history_;
  AuditChoice audits_;
  std::deque<Frame> frames_;  // in order of submission; ended ones leave from the front
  FrameId next_frame_ = 0;    // above every frame ever submitted
  LedgerCounts ended_counts_;
  double rate_total_ = 0;                    // tiles per second, over all slaves
  double round_trip_total_ = 0;              // likewise, seconds
  double tile_seconds_ = kTileSecondsGuess;  // of all slaves, recent mean
  bool has_measured_ = false;                // a tile was rendered
  DuplicationBudget budget_;
};

}  // namespace tessera::master
