// SPDX-License-Identifier: Apache-2.0
// One run of the storm: a cluster, an application, and what goes wrong when; all drawn from a seed.
// Threads. Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/sim/network.h"
#include "tests/sim/sim_app.h"

namespace tessera::sim {

struct SlavePlan {
  LinkModel link;
  int threads = 1;
  double tile_seconds = 0.01;  // mean
  double tile_spread = 0;      // a tile costs between (1 - spread) and (1 + spread) of the mean
  double build_seconds = 0.01;
  bool fails_builds = false;
  bool is_on_demand = false;  // builds meshes when the first ray reaches them, of edited scenes
  double joins_at = 0;        // seconds
};

// What a slave does all the while it is there.
enum class Vice {
  kDies,       // with the first tile that it begins, or a later one; it is started again at once
  kHoards,     // takes tiles and returns none
  kLies,       // its results answer no lease
  kTakesName,  // says that it is another slave
  kForges,     // its pixels are wrong; it leaves in order, again and again, and comes back
  kCount
};
// Those before it are drawn by chance; kForges has storms of its own.
constexpr Vice kVicesDrawn = Vice::kForges;
// The bad slaves of a storm stay until then at least, and for so long, in seconds; those that one
// tile ends until the master is certain that they do not come back from it.
constexpr double kBadSlavesUntil = 6, kBadSlavesStay = 3, kFatalTilesStay = 14;

struct BadSlavePlan {
  SlavePlan slave;
  Vice vice = Vice::kDies;
  int variant = 0;                 // which lie, which tile
  int victim = 0;                  // whose name is taken
  bool is_one_tile_fatal = false;  // kDies: with that tile of each frame, and with no other
  TileIndex fatal_tile = 0;
};

enum class FaultKind {
  kKill,       // the process dies; the system tells its peers
  kPowerLoss,  // the machine goes dark
  kHang,       // as under SIGSTOP
  kCutFrom,    // nothing from the slave's machine arrives at the master's
  kCutTo,      // nothing from the master's arrives at the slave's
  kCutBoth,
  kStallOne,  // one direction of one of its connections
  kReset,     // one of its connections
  kDelay,     // its link gets slower by 50 ms and jitters
  kSlowLink,  // 125,000 bytes/s
  kLeave,     // in order
  kMasterCrash,
  kMasterHang,
  kAppCrash,
  kAppHang,
  kAppCancels,
  kRelayCut,     // between two slaves, both directions
  kRelayStall,   // what one slave sends to another on the connections that they have
  kRelayReset,   // all connections between two slaves
  kRelayAlters,  // a slave alters the chunks that it passes on
  kFreeze,       // its render threads stand still
  kAppPause,  // as under SIGSTOP, for longer than the master waits for an application in some storms
  kWrongClock,  // the master's: it refuses everybody's certificate; its links are reset
  kCount
};
const char* fault_name(FaultKind kind);

struct Fault {
  double at = 0;        // seconds
  double duration = 0;  // then it is over: restarted, resumed, healed
  FaultKind kind = FaultKind::kKill;
  bool is_for_good = false;  // it is never over
  int slave = 0;             // whom it meets
  int variant = 0;           // which connection, which direction, which other slave
};

struct StormPlan {
  std::uint64_t seed = 0;
  LinkModel master_link;
  int frames_in_flight = 2;
  int slaves_min = 1;  // that must be there before the first frame begins
  double audit_share = 0;
  bool is_relaying = false;          // slaves feed slaves
  double master_record_seconds = 0;  // CPU of the master for each record
  std::vector<SlavePlan> slaves;
  std::vector<BadSlavePlan> bad_slaves;  // beside them
  int watchers = 0;                      // status clients that come and go
  AppScript script;
  std::vector<Fault> faults;

  int tile_count() const;
};

// The name that a bad slave has, unless it takes another's.
inline std::string name_of_bad_slave(std::size_t index) { return "bad" + std::to_string(index); }
inline bool is_name_of_bad_slave(const std::string& name) { return name.starts_with("bad"); }

StormPlan draw_storm(std::uint64_t seed);
std::string describe(const StormPlan& plan);

}  // namespace tessera::sim
