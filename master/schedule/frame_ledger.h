// SPDX-License-Identifier: Apache-2.0
// Who owes which tile of one frame. Pure: no clock, no thread, no IO.
//
// A tile is pending, leased (at most kLeasesPerTileMax times at once; where audits wait for slaves
// that have stalled, kLeasesKeptMax times) or done. Every lease ends
// once: accepted (its pixels are the tile's), rejected (valid, but not needed: the tile was done,
// or it only confirms), or abandoned (slave lost, tile handed back, frame ended). So issued ==
// accepted + rejected + abandoned + in_flight at every moment.
//
// An audited tile is rendered by two slaves; when they differ a third decides.
//
// Invariants. (1) A tile is done once. (2) Only a result that answers an outstanding lease
// (session, version, tile, attempt) counts. (3) A lost tile without another lease is pending again,
// at the head. (4) No two leases of one tile are of the same session, no two votes of one slave.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "master/schedule/result_author.h"
#include "master/schedule/result_verdict.h"
#include "master/schedule/tile_losses.h"

namespace tessera::master {

struct TileAssignment {
  TileIndex tile = 0;
  Attempt attempt = 0;
  bool is_comparison = false;  // audit: another slave has the tile, or has answered
  bool is_duplicate = false;   // leased a second time to end the frame sooner
};

struct LedgerCounts {
  std::uint64_t issued = 0, accepted = 0, rejected = 0, abandoned = 0, in_flight = 0;
  LedgerCounts& operator+=(const LedgerCounts& other);
};

// What became of one result.
struct LedgerAnswer {
  ResultVerdict verdict = ResultVerdict::kNotLeased;
  TimePoint leased_at{};      // if it answered a lease
  ResultAuthor outvoted{};    // audit: this slave's pixels were wrong
  ResultAuthor first_vote{};  // kDisputed, kUndecided: whose pixels it differs from
  ResultAuthor refused_of{};  // kAccepted: whose pixels of this tile were refused as faulty
};

// A lease that is out.
struct TileLeaseView {
  TileIndex tile = 0;
  SessionId session = 0;
  TimePoint since;
  TimePoint due;  // when the answer was expected, as the lease was issued
};

class FrameLedger {
 public:
  static constexpr int kLeasesPerTileMax = 2;
  static constexpr int kLeasesKeptMax = 4;
  static constexpr int kVotesMax = 2;  // kept of one tile

  // `order`: every tile once, in the order in which they are to be leased. Requires: not empty.
  FrameLedger(SceneVersion version, std::vector<TileIndex> order);

  SceneVersion version() const { return version_; }
  std::size_t pending_count() const { return pending_.size(); }
  // False: next_for() has nothing for anybody.
  bool may_lease() const { return !pending_.empty() || !audits_.empty(); }
  bool is_complete() const { return done_count_ == tiles_.size(); }
  const LedgerCounts& counts() const { return counts_; }
  bool has_audits() const { return !audits_.empty(); }
  // Whether a tile is begun and another slave's pixels of it may yet take the place of the first.
  bool is_audited(TileIndex tile) const { return audits_.contains(tile); }
  std::size_t tiles_left() const { return tiles_.size() - done_count_; }
  // How often the tile was leased so far. Requires: tile < tile_count().
  Attempt attempts(TileIndex tile) const { return tiles_[tile].attempts; }
  TileIndex tile_count() const { return static_cast<TileIndex>(tiles_.size()); }

  // Whether a session may have a tile that slaves were lost with; empty: it may have all of them.
  using LostTileFilter = std::function<bool(TileIndex)>;

  // The tile that a session would get next, if there is one: pending ones first, then audited ones,
  // none of which this session has seen.
  std::optional<TileIndex> next_for(SessionId session, const LostTileFilter& may_have = {}) const;
  // Leases the tile of next_for(). `due`: when the answer is expected. With `is_audited`, a tile
  // leased for the first time must be rendered by a second slave, too.
  std::optional<TileAssignment> lease_next(SessionId session, TimePoint now, TimePoint due,
                                           bool is_audited = false,
                                           const LostTileFilter& may_have = {});
  // Leases this tile, for schedules that do not follow the order. Requires: the tile is pending.
  TileAssignment lease_pending(TileIndex tile, SessionId session, TimePoint now, TimePoint due);
  const std::deque<TileIndex>& pending() const { return pending_; }

  // Leases once more a tile that is out. Returns: nothing when the tile is not out, out often
  // enough, done or audited, or when `session` has it or sent faulty pixels for it.
  // Slaves that have `stalled` do not count among those that it is out with.
  std::optional<TileAssignment> lease_again(TileIndex tile, SessionId session, TimePoint now,
                                            TimePoint due, const std::set<SessionId>& stalled = {});
  // Leases of tiles that are out once only and neither done nor audited, in the order of tiles; of
  // a tile that is out with slaves that have stalled, the lease of another, or else the last one.
  std::vector<TileLeaseView> single_leases(const std::set<SessionId>& stalled = {}) const;

  // `pixels`: a digest of the result's pixels; matters for audited tiles only. `is_suspect`: the
  // pixels are faulty, and another slave could render the tile: such results of the first slave
  // that sends one are refused, unless another one is there, and the tile goes to somebody else.
  LedgerAnswer accept(SessionId session, SceneVersion version, TileIndex tile, Attempt attempt,
                      std::uint64_t pixels = 0, bool is_suspect = false);
  // Call when no slave but this one is left: tiles refused of it may then be leased to it again.
  void waive_refusals(SessionId only);

  // The slave gives the tile back unrendered. Returns: false when it held no such lease.
  bool hand_back(SessionId session, TileIndex tile, Attempt attempt);

  // A slave is here, perhaps again.
  void slave_joined(SessionId session, const SlaveIdentity& slave);
  // The slave is gone. `is_suspect`: its tiles may be why, and count as lost with it.
  // Returns: the tile of those that it held and that are not done with the most attempts, if any.
  std::optional<TileIndex> lose_session(SessionId session, const SlaveIdentity& slave,
                                        bool is_suspect, TimePoint now);
  // Sessions that have the tile, or whose results for it were refused or are votes: they get it no
  // more. At most one of a refusal, kLeasesKeptMax of leases and kVotesMax.
  std::vector<SessionId> seen_by(TileIndex tile) const;
  std::vector<SessionId> holders(TileIndex tile) const;  // that have it now
  // What is known of tiles that slaves were lost with.
  TileLosses& losses() { return losses_; }
  const TileLosses& losses() const { return losses_; }

  struct Dispute {
    TileIndex tile = 0;
    ResultAuthor first, second;
  };
  // Audits that wait for nobody but these slaves, which return nothing, want another one.
  void audit_without(const std::set<SessionId>& silent);
  // Takes the tile's one result for good. Returns: false when it has none, or two that differ.
  bool waive_audit(TileIndex tile);
  // Ends audits that no slave is left for, that is, of tiles that all of `able` have seen or were
  // lost with, and none of them holds: tiles with one result are done. Returns: the first one with
  // two results that differ, if there is any.
  std::optional<Dispute> waive_audits(const std::vector<SessionId>& able);

  // Abandons every outstanding lease. Returns: how many there were.
  std::uint64_t abandon_all();

  // Memory that a frame's book takes for each of its tiles, while nothing is lost or audited.
  static constexpr std::size_t bytes_per_tile() { return sizeof(Tile) + 2 * sizeof(TileIndex); }

 private:
  struct Lease {
    SessionId session = 0;
    Attempt attempt = 0;
    TimePoint since, due;
  };
  struct Answer {
    SessionId session = 0;
    Attempt attempt = 0;
  };
  struct Tile {
    Attempt attempts = 0;
    std::uint8_t lease_count = 0;
    bool is_done = false;
    bool is_pending = true;
    Answer answer;  // the one that was accepted last
    std::array<Lease, kLeasesKeptMax> leases;

    std::span<const Lease> out() const { return std::span(leases).first(lease_count); }
  };
  struct Vote {
    ResultAuthor author;
    std::uint64_t pixels = 0;
  };
  struct Audit {
    std::array<Vote, kVotesMax> votes;
    int vote_count = 0;
    bool wants_lease = true;  // nobody renders it for comparison yet
  };

  struct Refusal {
    ResultAuthor author;
    bool is_waived = false;  // the slave may have the tile again, since nobody else could
  };

  TileAssignment lease(TileIndex tile, SessionId session, TimePoint now, TimePoint due);
  void end_lease(TileIndex tile, std::size_t lease);
  void make_pending(TileIndex index);
  void finish(TileIndex index);
  bool has_seen(TileIndex tile, SessionId session) const;
  std::size_t live_count(const Tile& tile, const std::set<SessionId>& stalled) const;
  // Calls `is_it` for each session of seen_by() until it returns true. Returns: whether it did.
  template <typename Predicate>
  bool is_any_of_seen(TileIndex tile, const Predicate& is_it) const;
  template <typename Do>
  void for_each_author(const Do& act);
  bool refuse(TileIndex tile, SessionId session);
  LedgerAnswer vote(TileIndex tile, Audit& audit, SessionId session, std::uint64_t pixels);

  const SceneVersion version_;
  std::vector<Tile> tiles_;
  std::deque<TileIndex> pending_;
  std::map<TileIndex, Refusal> refused_;  // with faulty pixels of one slave
  std::map<TileIndex, Audit> audits_;     // audited tiles begun and not done
  TileLosses losses_;
  LedgerCounts counts_;
  std::size_t done_count_ = 0;
};

}  // namespace tessera::master
