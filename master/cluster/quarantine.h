// SPDX-License-Identifier: Apache-2.0
// Which slaves are held back for a while. Slaves that break the protocol or send wrong results are
// held back at once; slaves that are lost again and again are when they cost more than they bring.
//
// A loss counts when the session had brought fewer tiles than it took with it: a slave that crashes
// on its first tiles is held back, one that is restarted by hand and works in between is not (its
// reconnects are spaced by its own back-off). The loss of a process that comes back is one of its
// link, and is forgotten. Wrong pixels of which nobody can say whether the scene is to blame count
// when another slave renders the tile without them.
//
// Threads. Pure: times go in. One owner thread.
//
// Invariants. (1) Each time a name is held back, it is for twice as long as before, from kFirst to
// kLongest; after kForgiven without an offence its record begins anew. (2) At most kNamesMax names
// are known; the one whose last offence is oldest is forgotten first.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/limits.h"
#include "common/frame/frame_stats.h"

namespace tessera::master {

class Quarantine {
 public:
  // So many losses, or results with wrong pixels, within the window hold a slave back.
  static constexpr std::size_t kLossesMax = kTileAttemptsMax;
  static constexpr std::size_t kWrongMax = 3;
  static constexpr std::chrono::minutes kWindow{1};
  static constexpr std::chrono::seconds kFirst{30};
  static constexpr std::chrono::minutes kLongest{16};
  static constexpr std::chrono::hours kForgiven{1};
  static constexpr std::size_t kNamesMax = kConnectionsMax;

  // A session of `name` ended without a goodbye. `instance`: of its process, 0 where that is not
  // known. Returns: whether it is held back now.
  bool count_loss(const std::string& name, std::uint64_t instance, std::uint64_t tiles_brought,
                  std::uint32_t tiles_held, TimePoint now);
  // That process of `name` is here again: what it was lost for was its link.
  void forget_losses(const std::string& name, std::uint64_t instance, TimePoint now);
  // A result of `name` was refused, and another slave's for the same tile had no such pixels.
  // Returns: whether that was one too many.
  bool count_wrong(const std::string& name, TimePoint now);
  // `name` broke the protocol or sent wrong results, and is held back at once.
  void count_violation(const std::string& name, const std::string& reason, TimePoint now);

  // How long `name` is still held back, and why; nothing when it may come.
  std::optional<QuarantinedSlave> find(const std::string& name, TimePoint now) const;
  std::vector<QuarantinedSlave> entries(TimePoint now) const;  // those held back now, by name

 private:
  struct Loss {
    TimePoint at;
    std::uint64_t instance = 0;
  };
  struct Record {
    std::vector<Loss> losses;      // within the window, oldest first
    std::vector<TimePoint> wrong;  // likewise
    std::vector<Loss> held_for;    // losses that it is held back for; empty: for something else
    std::uint32_t times = 0;       // held back so far
    TimePoint until{};
    TimePoint last_offence{};
    std::string reason;
  };

  Record& record_of(const std::string& name, TimePoint now);
  static void hold(Record& record, const std::string& reason, TimePoint now);

  std::map<std::string, Record> records_;
};

}  // namespace tessera::master
