// SPDX-License-Identifier: Apache-2.0
// Which slaves were lost while they held a tile of one frame, and what may follow from that. A tile
// that ends every slave that renders it must end few of them, and a slave that ends with any tile
// must not be held against the tiles. Pure, as the ledger that owns it.
//
// Every tile that a lost slave held counts, since nobody knows which of them it had begun: results
// that were done and not yet sent are gone with it, so the tile in rendering may stand anywhere. A
// loss is certain once the slave is back as another process, or was away for DepartedSlaves::
// kReturn. One that comes back as the same process had a broken link; its loss is forgotten.
//
// Threads. The owner's.
//
// A slave that ends again before it has brought what its last end cost, and not with the same tile,
// ends with anything: it is no witness against a tile, and only witnesses fail one.
//
// Invariants. (1) Attempts count different slaves: a slave that was lost twice with a tile is one.
// (2) Of one tile at most kTileAttemptsMax witnesses are known, and fewer that are none.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "master/schedule/slave_identity.h"

namespace tessera::master {

class TileLosses {
 public:
  enum class Case {
    kNone,      // no slave was lost with it
    kOpen,      // others may try it; whoever was lost with it may, when nobody else can
    kOthers,    // lost so often that only slaves that were not lost with it may try it
    kAwaited,   // lost with as many slaves as may be, some of which may only have a broken link
    kHopeless,  // lost for certain with as many slaves as may be: its frame fails
  };

  // A slave that held the tile is gone.
  void lost(TileIndex tile, const SlaveIdentity& slave, TimePoint now);
  // The slave, whose losses of this moment are told, ends with anything.
  void discredit(const SlaveIdentity& slave, TimePoint now);
  // A slave is here, perhaps again.
  void joined(SessionId session, const SlaveIdentity& slave);
  // Call now and then: losses from which nobody came back become certain.
  void settle(TimePoint now);
  void done(TileIndex tile) { tiles_.erase(tile); }

  bool is_empty() const { return tiles_.empty(); }
  Case of(TileIndex tile) const;
  std::size_t slave_count(TileIndex tile) const;  // that were lost with it
  std::size_t witness_count(TileIndex tile) const;
  // When a slave was lost with it last. Requires: one was.
  TimePoint last_at(TileIndex tile) const;
  // Whether every loss of the tile is certain.
  bool is_certain(TileIndex tile) const;
  // Sessions of slaves that were lost with the tile and are here again, or were.
  std::vector<SessionId> sessions(TileIndex tile) const;
  std::vector<TileIndex> tiles() const;  // that a slave was lost with
  // "'a' and 'b'": who was lost with the tile, for people.
  std::string names(TileIndex tile) const;

 private:
  struct Loss {
    SlaveIdentity slave;  // as it was when it was lost
    int times = 0;
    bool is_certain = false;  // the last time; earlier ones are
    bool is_witness = true;
    TimePoint at{};
    SessionId session = 0;  // that it has since; 0: it has not come back
  };

  std::map<TileIndex, std::vector<Loss>> tiles_;
};

}  // namespace tessera::master
