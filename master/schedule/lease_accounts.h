// SPDX-License-Identifier: Apache-2.0
// Where each slave's leases went, kept apart from the scheduler, which decides. The frame loop
// tells what it did and heard, so that the sums here check the scheduler's. Pure: no clock, no
// thread, no IO.
//
// Invariants. (1) issued == accepted + rejected + abandoned + in_flight, for each session and in
// total, after every call. (2) Bounded by sessions times frames in flight.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/base/clock.h"
#include "common/base/ids.h"
#include "common/frame/frame_stats.h"
#include "master/schedule/frame_ledger.h"

namespace tessera::master {

class LeaseAccounts {
 public:
  void leased(SessionId session, FrameId frame, const TileAssignment& tile, TimePoint now = {});
  // A result came, or a tile came back unrendered. Ignored when no such lease is outstanding.
  void answered(SessionId session, FrameId frame, const TileAssignment& tile, bool is_accepted);
  void handed_back(SessionId session, FrameId frame, const TileAssignment& tile);
  // By an audit, one of the slave's results that was accepted is rejected after all.
  void overruled(SessionId session);
  // The slave was told that the frame is over; what it still holds of the frame is abandoned.
  void frame_ended(SessionId session, FrameId frame);
  void slave_lost(SessionId session);

  // Returns: nothing when no such lease is outstanding.
  std::optional<TimePoint> leased_at(SessionId session, FrameId frame,
                                     const TileAssignment& tile) const;

  // Zero for a session that is gone or never leased.
  TileAccounts of(SessionId session) const;
  TileAccounts total() const;

 private:
  struct Lease {
    std::uint64_t key = 0;  // tile and attempt
    TimePoint since;
  };
  struct Account {
    TileAccounts counts;  // in_flight: the sum over `outstanding`
    // Leases by frame, in no strict order: a slave holds some tens, and those near the front, the
    // oldest, tend to be answered first.
    std::map<FrameId, std::vector<Lease>> outstanding;
  };

  Account* end_lease(SessionId session, FrameId frame, const TileAssignment& tile);

  std::map<SessionId, Account> accounts_;
  TileAccounts gone_;
};

}  // namespace tessera::master
