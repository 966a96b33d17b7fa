// Who owes which tile of one frame. Pure: no clock, no thread, no IO.
//
// A tile is pending, leased (at most kLeasesPerTileMax times at once) or done. Every lease ends
// once: accepted (first valid result), rejected (a later valid result), or abandoned (slave lost,
// tile handed back, frame ended). So issued == accepted + rejected + abandoned + in_flight at every
// moment.
//
// Invariants. (1) A tile is accepted once. (2) Only a result that answers an outstanding lease
// (session, version, tile, attempt) is accepted. (3) A lost tile without another lease is pending
// again, at the head.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"

namespace tessera::master {

struct TileAssignment {
  TileIndex tile = 0;
  Attempt attempt = 0;
};

enum class ResultVerdict {
  kAccepted,
  kDuplicate,     // answers a lease, but the tile was done already: dropped and counted
  kFrameEnded,    // answers a frame that is over: dropped
  kUnknownFrame,  // never begun on that slave: a violation
  kWrongVersion,  // violation
  kNotLeased,     // no such lease of that session: violation
};
const char* verdict_text(ResultVerdict verdict);

struct LedgerCounts {
  std::uint64_t issued = 0, accepted = 0, rejected = 0, abandoned = 0, in_flight = 0;
};

class FrameLedger {
 public:
  static constexpr int kLeasesPerTileMax = 2;

  // Requires: tile_count >= 1.
  FrameLedger(SceneVersion version, TileIndex tile_count);

  SceneVersion version() const { return version_; }
  bool has_pending() const { return !pending_.empty(); }
  bool is_complete() const { return counts_.accepted == tiles_.size(); }
  const LedgerCounts& counts() const { return counts_; }
  std::uint32_t reissued_count() const { return reissued_count_; }
  // How often the tile was leased so far. Requires: tile < tile_count().
  Attempt attempts(TileIndex tile) const { return tiles_[tile].attempts; }
  TileIndex tile_count() const { return static_cast<TileIndex>(tiles_.size()); }

  // Leases the first pending tile.
  std::optional<TileAssignment> lease_next(SessionId session, TimePoint now);

  // Leases once more the tile whose lease is oldest, if that is older than `overdue` and none of
  // `session`'s.
  std::optional<TileAssignment> lease_again(SessionId session, TimePoint now, Duration overdue);

  ResultVerdict accept(SessionId session, SceneVersion version, TileIndex tile, Attempt attempt);

  // The slave gives the tile back unrendered. Returns: false when it held no such lease.
  bool hand_back(SessionId session, TileIndex tile, Attempt attempt);

  // The slave is gone. `suspect_count` of its oldest leases may have been in rendering; each counts
  // as one loss of its tile. Returns: the greatest number of losses of one tile so far.
  int lose_session(SessionId session, std::size_t suspect_count);

  // Every outstanding lease is abandoned. Returns: how many there were.
  std::uint64_t abandon_all();

 private:
  struct Lease {
    SessionId session = 0;
    Attempt attempt = 0;
    TimePoint since;
  };
  struct Tile {
    bool is_done = false;
    bool is_pending = true;
    Attempt attempts = 0;
    int losses = 0;
    std::vector<Lease> leases;
  };

  TileAssignment lease(TileIndex tile, SessionId session, TimePoint now);
  void end_lease(TileIndex tile, std::size_t lease);
  void make_pending(TileIndex index);

  const SceneVersion version_;
  std::vector<Tile> tiles_;
  std::deque<TileIndex> pending_;
  std::set<TileIndex> leased_;  // tiles with a lease
  LedgerCounts counts_;
  std::uint32_t reissued_count_ = 0;
};

}  // namespace tessera::master
