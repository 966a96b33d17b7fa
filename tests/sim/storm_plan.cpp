// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/storm_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "common/frame/tile_grid.h"

namespace tessera::sim {
namespace {

constexpr std::array<const char*, static_cast<std::size_t>(FaultKind::kCount)> kNames = {
    "kill",        "power loss",   "hang",     "cut from",    "cut to",     "cut both",
    "stall one",   "reset",        "delay",    "slow link",   "leave",      "master crash",
    "master hang", "app crash",    "app hang", "app cancels", "relay cut",  "relay stall",
    "relay reset", "relay alters", "freeze",   "app pause",   "wrong clock"};

// Share of the storms whose scenes change and pass from slave to slave.
constexpr double kRelayShare = 0.03;
// Share of the storms with slaves that do what no slave should, and of those with frozen threads.
constexpr double kBadShare = 0.15, kFreezeShare = 0.1;
// Of those with bad slaves: with as many that die as a tile may end, and good ones beside them.
constexpr double kMortalShare = 0.3;
// Shares of the storms where slaves that die come late, and where one forges pixels.
constexpr double kLateShare = 0.02, kForgerShare = 0.02;
// Share of the storms whose scenes move with time.
constexpr double kMotionShare = 0.15;
// Share of the storms whose scenes differ by edits, and are built.
constexpr double kEditedShare = 0.06;
// Share of the storms with status clients, with an application that stands still for long, and with
// a master whose clock is wrong for a while.
constexpr double kWatcherShare = 0.15, kAppPauseShare = 0.04, kWrongClockShare = 0.06;
// Bytes per second. Heartbeats wait behind the windows of whoever fed a slave, feeds it, and the
// master: 0.4 s here, a third of what it takes to be called dead. Below, a queue that no machine
// has would end sessions.
constexpr double kRelayDownMin = 2e6;

LinkModel draw_link(Random& random) {
  constexpr std::array<double, 5> kRates = {0, 100e6, 10e6, 2e6, 500e3};
  LinkModel link;
  link.up_bytes_per_s = kRates[static_cast<std::size_t>(random.pick(0, 4))];
  link.down_bytes_per_s = kRates[static_cast<std::size_t>(random.pick(0, 4))];
  link.delay = from_seconds(random.chance(0.5) ? random.between(20e-6, 500e-6)
                                               : random.between(0.5e-3, 25e-3));
  if (random.chance(0.3)) link.jitter = from_seconds(random.between(0, 20e-3));
  return link;
}

SlavePlan draw_slave(Random& random) {
  SlavePlan slave;
  slave.link = draw_link(random);
  slave.threads = random.pick(1, 4);
  slave.tile_seconds = random.between(1, 6) * (random.chance(0.4) ? 20e-3 : 5e-3);
  slave.tile_spread = random.between(0, 0.9);
  slave.build_seconds = random.chance(0.2) ? random.between(0.1, 0.6) : random.between(1e-3, 30e-3);
  return slave;
}

Fault draw_fault(Random& random, int slave_count) {
  Fault fault;
  fault.at = random.between(0.1, 5);
  fault.kind = static_cast<FaultKind>(random.pick(0, static_cast<int>(FaultKind::kRelayCut) - 1));
  // Some faults are shorter than it takes to notice them, some longer.
  fault.duration = random.chance(0.5) ? random.between(0.05, 1.2) : random.between(1.2, 5);
  fault.slave = random.pick(0, slave_count - 1);
  fault.variant = random.pick(0, 3);
  return fault;
}

// Makes tiles take longer than it takes to lose a master and find it again, so that what was begun
// for one session ends in the next. There are few of them, so that frames do not take minutes.
void draw_long_tiles(Random& random, StormPlan& plan) {
  plan.script.tile_edge_px = 32;
  for (SlavePlan& slave : plan.slaves) slave.tile_seconds = random.between(0.3, 2);
}

// Makes slaves feed each other in every storm of heavy scenes, and in some others, whose scenes
// change. It draws from numbers of its own: seeds keep what else they were.
void draw_relays(StormPlan& plan) {
  Random random(mix(plan.seed ^ 0x72656c61797321u));
  if (random.chance(kRelayShare)) {
    plan.script.weight = SceneWeight::kChanging;
    plan.script.scene_change = random.between(0.2, 0.7);
    for (int more = random.pick(1, 4); more > 0; --more) plan.slaves.push_back(draw_slave(random));
  }
  plan.is_relaying = plan.script.weight != SceneWeight::kLight;
  if (!plan.is_relaying || plan.slaves.size() < 2) return;
  for (SlavePlan& slave : plan.slaves) {
    double& rate = slave.link.down_bytes_per_s;
    if (rate > 0) rate = std::max(rate, kRelayDownMin);
  }
  for (int count = random.pick(1, 5); count > 0; --count) {
    Fault fault = draw_fault(random, static_cast<int>(plan.slaves.size()));
    fault.kind = static_cast<FaultKind>(random.pick(static_cast<int>(FaultKind::kRelayCut),
                                                    static_cast<int>(FaultKind::kRelayAlters)));
    if (random.chance(0.7)) fault.at = random.between(0, 1);  // the first scene is on its way
    fault.is_for_good = random.chance(0.5);
    plan.faults.push_back(fault);
  }
}

// Gives slaves that die every chance: each frame has a scene of its own, which they are the first
// to have built. Faults meet the first good slave alone, so that the others have no excuse.
void let_the_bad_be_first(Random& random, StormPlan& plan) {
  plan.script.scene_change = 1;
  for (SlavePlan& slave : plan.slaves) slave.build_seconds = random.between(0.3, 0.8);
  std::erase_if(plan.faults, [](const Fault& fault) {
    return fault.kind >= FaultKind::kMasterCrash && fault.kind != FaultKind::kAppCancels;
  });
  for (Fault& fault : plan.faults) fault.slave = 0;
}

// Adds slaves that die, hoard, lie and take names, and lets others freeze. It draws from numbers of
// its own: seeds keep what else they were.
void draw_bad_slaves(StormPlan& plan) {
  constexpr std::array<int, 4> kThreads = {1, 4, 16, 64};
  Random random(mix(plan.seed ^ 0x766963657321u));
  const int slave_count = static_cast<int>(plan.slaves.size());
  if (random.chance(kBadShare)) {
    const bool are_mortal = random.chance(kMortalShare);
    if (are_mortal) let_the_bad_be_first(random, plan);
    for (int count = are_mortal ? 3 : random.pick(1, 3); count > 0; --count) {
      BadSlavePlan bad;
      bad.slave = draw_slave(random);
      bad.vice = static_cast<Vice>(random.pick(0, static_cast<int>(kVicesDrawn) - 1));
      if (are_mortal) bad.vice = Vice::kDies;
      bad.variant = random.pick(0, 3);
      bad.victim = random.pick(0, slave_count - 1);
      bad.slave.threads = bad.vice == Vice::kTakesName
                              ? plan.slaves[static_cast<std::size_t>(bad.victim)].threads
                              : kThreads[static_cast<std::size_t>(random.pick(0, 3))];
      bad.slave.joins_at = random.chance(0.5) ? 0 : random.between(0, 3);
      plan.bad_slaves.push_back(bad);
    }
  }
  if (!random.chance(kFreezeShare)) return;
  for (int count = random.pick(1, 2); count > 0; --count) {
    Fault fault = draw_fault(random, slave_count);
    fault.kind = FaultKind::kFreeze;
    plan.faults.push_back(fault);
  }
}

// Slaves that die come when the good ones have proven themselves, and before any of those has built
// the next scene. One alone ends with the same tile in each of its lives, having brought others,
// and is no proof against that tile; of three that are new the last one must not get its last try.
void draw_late_deaths(Random& random, StormPlan& plan) {
  let_the_bad_be_first(random, plan);
  for (SlavePlan& slave : plan.slaves) {
    slave.joins_at = 0;
    slave.build_seconds = random.between(3, 5);
  }
  // Many tiles, but where they take long.
  if (plan.script.tile_edge_px < 32) plan.script.tile_edge_px = 8;
  const bool is_alone = random.chance(0.5);
  const double joins_at = random.between(6, 8);
  for (int count = is_alone ? 1 : 3; count > 0; --count) {
    BadSlavePlan bad;
    bad.slave.link.delay = from_seconds(random.between(20e-6, 5e-3));
    bad.slave.build_seconds = random.between(1e-3, 30e-3);
    bad.slave.tile_seconds = random.between(1e-3, 10e-3);
    bad.slave.threads = is_alone ? random.pick(1, 3) : 64;
    bad.slave.joins_at = joins_at + random.between(0, 0.1);
    bad.variant = random.pick(0, 1);
    bad.is_one_tile_fatal = is_alone;
    bad.fatal_tile = static_cast<TileIndex>(random.pick(0, plan.tile_count() - 1));
    plan.bad_slaves.push_back(bad);
  }
}

// Each tile is compared, and one slave of several has wrong pixels. It is the fastest, so that it
// is back before anybody has compared what it sent. No fault meets the others: tiles that a stalled
// slave is tried with are not compared.
void draw_forger(Random& random, StormPlan& plan) {
  plan.audit_share = 1;
  plan.slaves_min = 3;  // a tile that is leased while nobody could compare it is not compared later
  plan.faults.clear();
  while (plan.slaves.size() < 3) plan.slaves.push_back(draw_slave(random));
  for (SlavePlan& slave : plan.slaves) {
    slave.joins_at = 0;
    slave.fails_builds = false;
    slave.link.up_bytes_per_s = slave.link.down_bytes_per_s = 100e6;
    slave.tile_seconds = random.between(0.05, 0.2);
  }
  BadSlavePlan bad;
  bad.slave.link.delay = from_seconds(random.between(20e-6, 5e-3));
  bad.slave.threads = random.pick(1, 4);
  bad.slave.tile_seconds = random.between(1e-3, 10e-3);
  bad.slave.build_seconds = random.between(1e-3, 10e-3);
  bad.vice = Vice::kForges;
  bad.variant = random.pick(0, 3);
  bad.slave.joins_at = random.between(2, 3);
  plan.bad_slaves.push_back(bad);
}

// Storms of scenes that are light, and of no bad slaves so far. It draws from numbers of its own:
// seeds keep what else they were.
void draw_special_slaves(StormPlan& plan) {
  Random random(mix(plan.seed ^ 0x7370656369616cu));
  const double which = random.unit();
  if (plan.script.weight != SceneWeight::kLight || !plan.bad_slaves.empty()) return;
  if (which < kForgerShare) return draw_forger(random, plan);
  if (which < kForgerShare + kLateShare && plan.slaves.size() > 1) draw_late_deaths(random, plan);
}

// Lets scenes move with the frames' times, and slaves build ten times as long as the others. It
// draws from numbers of its own: seeds keep what else they were.
void draw_motion(StormPlan& plan) {
  Random random(mix(plan.seed ^ 0x6d6f74696f6eu));
  if (plan.script.weight != SceneWeight::kLight || !random.chance(kMotionShare)) return;
  plan.script.weight = SceneWeight::kMoving;
  for (SlavePlan& slave : plan.slaves) {
    if (random.chance(0.2)) slave.build_seconds *= 10;
    if (random.chance(0.03)) slave.fails_builds = &slave != &plan.slaves.front();
  }
}

// Makes every frame or most of them show a scene that was edited, on slaves that build it. It draws
// from numbers of its own: seeds keep what else they were.
void draw_edits(StormPlan& plan) {
  Random random(mix(plan.seed ^ 0x6564697473u));
  if (plan.script.weight != SceneWeight::kLight || !plan.bad_slaves.empty()) return;
  if (!random.chance(kEditedShare)) return;
  plan.script.weight = SceneWeight::kEdited;
  plan.script.scene_change = random.chance(0.5) ? 1 : random.between(0.5, 1);
  for (SlavePlan& slave : plan.slaves) {
    slave.is_on_demand = random.chance(0.3);
    if (random.chance(0.2)) slave.build_seconds *= 10;
    if (random.chance(0.03)) slave.fails_builds = &slave != &plan.slaves.front();
  }
}

// Adds status clients, pauses of the application and a clock that jumps, by numbers of its own:
// seeds keep what else they were.
void draw_others(StormPlan& plan) {
  Random random(mix(plan.seed ^ 0x6f7468657273u));
  if (random.chance(kWatcherShare)) plan.watchers = random.pick(1, 6);
  const auto add = [&](FaultKind kind, double duration) {
    Fault fault;
    fault.at = random.between(0.1, 4);
    fault.kind = kind;
    fault.duration = duration;
    fault.variant = random.pick(0, 3);
    plan.faults.push_back(fault);
  };
  if (random.chance(kAppPauseShare)) add(FaultKind::kAppPause, random.between(5, 25));
  if (random.chance(kWrongClockShare)) add(FaultKind::kWrongClock, random.between(0.5, 40));
}

const char* weight_text(SceneWeight weight) {
  switch (weight) {
    case SceneWeight::kLight:
      return "";
    case SceneWeight::kHeavy:
      return ", heavy scenes";
    case SceneWeight::kChanging:
      return ", changing scenes";
    case SceneWeight::kMoving:
      return ", moving scenes";
    case SceneWeight::kEdited:
      return ", edited scenes";
  }
  return "";
}

}  // namespace

const char* fault_name(FaultKind kind) { return kNames[static_cast<std::size_t>(kind)]; }

int StormPlan::tile_count() const {
  return static_cast<int>(
      TileGrid(script.width_px, script.height_px, script.tile_edge_px).tile_count());
}

StormPlan draw_storm(std::uint64_t seed) {
  Random random(seed);
  StormPlan plan;
  plan.seed = seed;
  plan.master_link.delay = std::chrono::microseconds(50);
  plan.master_link.down_bytes_per_s = 100e6;
  plan.frames_in_flight = random.chance(0.2) ? 1 : 2;
  plan.master_record_seconds = random.chance(0.3) ? 20e-6 : 0;
  const int slave_count = random.pick(1, 6);
  for (int i = 0; i < slave_count; ++i) plan.slaves.push_back(draw_slave(random));
  for (std::size_t i = 1; i < plan.slaves.size(); ++i) {
    if (random.chance(0.2)) plan.slaves[i].joins_at = random.between(0.2, 4);
    if (random.chance(0.04)) plan.slaves[i].fails_builds = true;
  }
  AppScript& script = plan.script;
  script.frames = random.pick(3, 12);
  script.tile_edge_px = random.chance(0.5) ? 8 : 16;
  script.width_px = random.pick(33, 96);
  script.height_px = random.pick(17, 64);
  script.in_flight = random.pick(1, 2);
  script.scene_change = random.chance(0.3) ? 1 : random.between(0, 0.5);
  script.cancel = random.chance(0.2) ? 0.1 : 0;
  script.pause_seconds = random.chance(0.5) ? 0.3 : 0;
  if (random.chance(0.02)) script.weight = SceneWeight::kHeavy;
  if (random.chance(0.9)) {  // the other plans have no faults
    for (int i = random.pick(1, 7); i > 0; --i) {
      plan.faults.push_back(draw_fault(random, slave_count));
    }
  }
  plan.audit_share = random.chance(0.25) ? 0.1 : 0;
  if (random.chance(0.1)) draw_long_tiles(random, plan);
  draw_relays(plan);
  draw_bad_slaves(plan);
  draw_others(plan);
  draw_motion(plan);
  draw_special_slaves(plan);
  draw_edits(plan);
  std::stable_sort(plan.faults.begin(), plan.faults.end(),
                   [](const Fault& a, const Fault& b) { return a.at < b.at; });
  return plan;
}

std::string describe(const StormPlan& plan) {
  char line[256];
  std::snprintf(line, sizeof(line),
                "seed %llu: %zu slaves, %d frames of %dx%d (%d tiles), %d in flight%s\n",
                static_cast<unsigned long long>(plan.seed), plan.slaves.size(), plan.script.frames,
                plan.script.width_px, plan.script.height_px, plan.tile_count(),
                plan.script.in_flight, weight_text(plan.script.weight));
  std::string text = line;
  for (std::size_t i = 0; i < plan.slaves.size(); ++i) {
    const SlavePlan& s = plan.slaves[i];
    std::snprintf(line, sizeof(line),
                  "  s%zu: %d threads, %.1f ms a tile, up %.0f down %.0f kB/s, delay %.2f ms%s%s\n",
                  i, s.threads, 1e3 * s.tile_seconds, 1e-3 * s.link.up_bytes_per_s,
                  1e-3 * s.link.down_bytes_per_s, 1e3 * seconds(s.link.delay),
                  s.joins_at > 0 ? ", joins late" : "", s.fails_builds ? ", fails builds" : "");
    text += line;
  }
  constexpr std::array<const char*, 5> kVices = {"dies", "hoards", "lies", "takes the name of",
                                                 "forges beside"};
  for (std::size_t i = 0; i < plan.bad_slaves.size(); ++i) {
    const BadSlavePlan& bad = plan.bad_slaves[i];
    std::snprintf(line, sizeof(line), "  bad%zu: %d threads, from %.3f s, %s (%d) s%d\n", i,
                  bad.slave.threads, bad.slave.joins_at, kVices[static_cast<std::size_t>(bad.vice)],
                  bad.variant, bad.victim);
    text += line;
  }
  if (plan.watchers > 0) text += "  " + std::to_string(plan.watchers) + " status clients\n";
  for (const Fault& f : plan.faults) {
    std::snprintf(line, sizeof(line), "  %.3f s: %s s%d for %.3f s (%d)\n", f.at,
                  fault_name(f.kind), f.slave, f.is_for_good ? INFINITY : f.duration, f.variant);
    text += line;
  }
  return text;
}

}  // namespace tessera::sim
