// SPDX-License-Identifier: Apache-2.0
#include "tests/sim/oracle.h"

#include <algorithm>

#include "common/base/limits.h"
#include "common/wire/codec.h"
#include "common/wire/record_types.h"
#include "master/cluster/relay_plan.h"
#include "slave/relay_feeder.h"

namespace tessera::sim {
namespace {

constexpr double kHeartbeat = 1e-3 * kHeartbeatMs;
constexpr double kDetection = kHeartbeat * (kHeartbeatsMissedMax + 1);  // T_det without RTT
constexpr double kHandshake = 1e-3 * kHandshakeMs;
constexpr double kReconnect = 1e-3 * kReconnectMaxMs;
// kRest: how long a slave that handed tiles back gets none (Scheduler). kOverdue: tiles are leased
// again after at least this (A of the fault matrix).
constexpr double kRest = 5, kOverdue = 0.5;
// kSweep: how often the master looks at feeders.
constexpr double kSweep = 0.5;
constexpr auto kRelayWindow = master::RelayPlan::kWindow;
// Silence is looked for every kSilenceLook, and noticed at most kSilenceSlack after it is due.
constexpr double kSilenceLook = 0.02, kSilenceSlack = 0.1;
// A slave that is there for so long has built the scenes that are needed.
constexpr double kSettled = 1;
constexpr double kWindowBytes = 256 * 1024;  // what may be on its way when a slave dies

// Bounds of the send queue of one connection. Bulk data is queued while less than the low mark
// waits, in pieces of at most half of it; small messages go beside it.
constexpr std::uint64_t kMasterQueueMax =
    net::kSendQueueLowBytes + net::kSendQueueLowBytes / 2 + 64 * 1024;
// A feeder queues a chunk while at most the low mark waits; a word of refusal may follow.
constexpr std::uint64_t kRelayQueueMax =
    net::kSendQueueLowBytes + kSceneChunkBytes + kRecordHeaderBytesMax;
// Connections of a slave: two to the master, one to its feeder, and those of its children.
constexpr std::size_t kSlaveEndsMax = 3 + slave::RelayFeeder::kChildrenMax;
constexpr std::uint64_t kSmallMessagesMax = 64 * 1024;
// Bound of planned events: records in flight, timers and tiles in work, for each connection and
// thread.
constexpr std::size_t kEventsPerSlaveMax = 4000;

// Of all blocks together, a little rounded up.
double bytes_of_scenes(SceneWeight weight) {
  if (weight == SceneWeight::kHeavy) return 3.5e6;
  if (weight == SceneWeight::kEdited) return 1e4;
  return weight == SceneWeight::kChanging ? 1.2e6 : 4e3;
}

std::uint16_t type_of_lease() {
  static const std::uint16_t type = wire::encode(wire::TileLease{}).type;
  return type;
}

std::uint16_t type_of_refusal() {
  static const std::uint16_t type = wire::encode(wire::Refuse{}).type;
  return type;
}

}  // namespace

Oracle::Oracle(const StormPlan& plan, const World& world)
    : plan_(plan),
      world_(world),
      watches_(plan.slaves.size()),
      scenes_(plan.slaves.size(), [this](const std::string& what) { report(what); }) {
  double slowest_alone = 0, slowest_send = 0, build = 0, rtt = 0;
  const double frame_bytes = 3.0 * plan.script.width_px * plan.script.height_px;
  const double scene_bytes = bytes_of_scenes(plan.script.weight);
  for (std::size_t i = 0; i < plan.slaves.size(); ++i) {
    const SlavePlan& slave = plan.slaves[i];
    by_name_["s" + std::to_string(i)] = i;
    watches_[i].troubled_until = slave.joins_at + 2;  // to connect and to build
    slowest_alone =
        std::max(slowest_alone, plan.tile_count() * slave.tile_seconds * 2 / slave.threads);
    const double rate = 125e3;  // the slow link's
    slowest_send = std::max(slowest_send, (frame_bytes + scene_bytes) / rate);
    build = std::max(build, slave.build_seconds);
    rtt = std::max(rtt, 2 * seconds(slave.link.delay + slave.link.jitter) + 0.3);
  }
  // After one fault the slowest slave may be alone with the frame: the fault is found, its tiles
  // are rendered again, and the rest comes at that slave's pace.
  progress_bound_ = kDetection + rtt + kRest + 2 * kOverdue + 3 * (slowest_alone + slowest_send) +
                    2 * build + 2 * plan.script.pause_seconds;
  // A scene: a feeder is found out after two windows at most, a child is given a few, and then the
  // master feeds it. What slow slaves above it hold up comes later.
  scenes_.set_wait_max(master::RelayPlan::kFeedersMax * (2 * seconds(kRelayWindow) + kSweep) +
                       2 * slowest_send + build + kRest);
  // Time to return: the longest pause, two tries of two handshakes, and what TCP holds up after a
  // cut.
  return_bound_ = kReconnect + 2 * (2 * kHandshake) + kDetection + 2 * slowest_send + build + 3;
}

void Oracle::report(const std::string& violation) {
  if (violation_.empty()) violation_ = violation;
}

void Oracle::trouble_slave(std::size_t slave, double until_seconds) {
  watches_[slave].troubled_until = std::max(watches_[slave].troubled_until, until_seconds);
  endings_.on_fault("s" + std::to_string(slave));
}

void Oracle::trouble_all(double until_seconds) {
  all_troubled_until_ = std::max(all_troubled_until_, until_seconds);
}

void Oracle::set_gone(std::size_t slave, bool is_gone) {
  watches_[slave].gone_since = is_gone ? world_.queue.now_seconds() : -1;
}

void Oracle::take_name(std::size_t slave, double until_seconds) {
  watches_[slave].name_taken_until = until_seconds + detection_bound(slave);
  trouble_slave(slave, until_seconds + return_bound_);
}

std::optional<std::size_t> Oracle::slave_at(int node) const {
  for (std::size_t i = 0; i < world_.slaves.size(); ++i) {
    if (world_.slaves[i]->node() == node) return i;
  }
  return std::nullopt;
}

void Oracle::on_sent(const Process& from, int to_node, const net::Record& record) {
  const bool is_by_master = &from == world_.master.process();
  if (is_by_master && record.type == type_of_lease()) ++leases_sent_;
  const auto sender = slave_at(from.node()), receiver = slave_at(to_node);
  if (sender && record.type == static_cast<std::uint16_t>(wire::RecordType::kTileResult))
    watches_[*sender].last_result = world_.queue.now_seconds();
  if (sender && receiver) return scenes_.on_said_between(*sender, record);
  const bool is_to_bad = is_by_master && !receiver && to_node != world_.app.node();
  if (record.type == type_of_refusal() && !is_to_bad) check_refusal(from, record);
  if (is_by_master && receiver) {
    scenes_.on_said_to(*receiver, record, world_.queue.now_seconds());
  } else if (sender) {
    scenes_.on_said_by(*sender, record);
  }
}

// Everybody here keeps the protocol, so nobody may be told that he broke it.
void Oracle::check_refusal(const Process& from, const net::Record& record) {
  const auto& bytes = record.payload.bytes;
  const auto message =
      wire::decode({record.type, record.header, std::vector(bytes.begin(), bytes.end())});
  const auto* const refuse = message.is_ok() ? std::get_if<wire::Refuse>(&*message) : nullptr;
  if (refuse == nullptr || refuse->code != wire::RefuseCode::kProtocol) return;
  report("I7: " + from.name() + " speaks of a breach of protocol: " + refuse->reason);
}

std::uint64_t Oracle::queue_bound(const Process& from, int to_node) const {
  if (&from == world_.master.process() || &from == world_.app.process()) return kMasterQueueMax;
  const auto slave = by_name_.find(from.name());
  if (slave == by_name_.end()) return kMasterQueueMax;
  if (to_node != world_.master.node()) return kRelayQueueMax;
  const auto tile_bytes = 3 * static_cast<std::uint64_t>(plan_.script.tile_edge_px) *
                          static_cast<std::uint64_t>(plan_.script.tile_edge_px);
  const auto tiles = static_cast<std::uint64_t>(plan_.slaves[slave->second].threads) *
                     static_cast<std::uint64_t>(kTilesPerWorkerMax);
  return kSmallMessagesMax + tiles * (tile_bytes + 256);
}

void Oracle::on_queued(const Process& from, int to_node, std::uint64_t queue_bytes) {
  const std::uint64_t bound = queue_bound(from, to_node);
  if (queue_bytes <= bound) return;
  report("I4: " + from.name() + " has " + std::to_string(queue_bytes) +
         " bytes in one send queue, bound " + std::to_string(bound));
}

void Oracle::on_outcome(FrameId frame, const Status& status) {
  const double now = world_.queue.now_seconds();
  last_progress_ = now;
  if (status.is_ok() || status.code() == StatusCode::kCancelled) return;
  if (endings_.do_excuse(status.message())) return;
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    const Watch& watch = watches_[i];
    if (!is_healthy(i) || !watch.was_listed || now - watch.listed_since < kSettled) continue;
    return report("I6: frame " + std::to_string(frame) + " failed while s" + std::to_string(i) +
                  " was there and healthy: " + status.message());
  }
}

bool Oracle::is_healthy(std::size_t slave) const {
  const double now = world_.queue.now_seconds();
  const SimSlave& it = *world_.slaves[slave];
  return it.is_running() && !it.is_hung() && !it.is_leaving() &&
         now > watches_[slave].troubled_until && now > all_troubled_until_ &&
         !plan_.slaves[slave].fails_builds;
}

double Oracle::detection_bound(std::size_t slave) const {
  const LinkModel& link = world_.network.link(world_.slaves[slave]->node());
  double bound = kDetection + 2 * kHeartbeat + 4 * seconds(link.delay + link.jitter) + 0.2;
  for (const double rate : {link.up_bytes_per_s, link.down_bytes_per_s}) {
    if (rate > 0) bound += kWindowBytes / rate;
  }
  return bound;
}

void Oracle::check() {
  if (!violation_.empty()) return;
  if (world_.queue.size() > kEventsPerSlaveMax * (1 + plan_.slaves.size())) {
    return report("I4: " + std::to_string(world_.queue.size()) + " events are planned");
  }
  check_silence();
  const Process* master = world_.master.process();
  if (master == nullptr || world_.master.is_hung()) return;
  if (master == master_seen_ && master->task_count() == master_tasks_seen_) return;  // no news
  master_seen_ = master;
  master_tasks_seen_ = master->task_count();
  const ClusterStatus status = world_.master.loop().counts();
  check_accounts(status);
  endings_.on_counts(status, world_.queue.now_seconds());
  check_slaves(status);
  check_progress(status);
}

// A process gives up a connection on which nothing comes after T_det; a process that hung, T_det
// after it went on.
void Oracle::check_silence() {
  const double now = world_.queue.now_seconds();
  if (now - silence_looked_ < kSilenceLook) return;
  silence_looked_ = now;
  const auto silence = [&](const Process& process, int node, double hung_at) {
    const TimePoint heard = world_.network.heard_from(process, node);
    return std::min(seconds(world_.queue.now() - heard), now - hung_at);
  };
  const Process* const master = world_.master.process();
  if (world_.master.is_hung()) master_hung_at_ = now;
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    const SimSlave& slave = *world_.slaves[i];
    if (slave.is_hung()) watches_[i].hung_at = now;
    if (slave.is_running() && !slave.is_hung()) {
      const double silent = silence(*slave.process(), world_.master.node(), watches_[i].hung_at);
      if (silent > kDetection + kSilenceSlack) {
        report("I6: " + slave.name() + " has heard nothing from the master for " +
               std::to_string(silent) + " s and still holds on to it");
      }
    }
    if (master == nullptr || world_.master.is_hung()) continue;
    const double silent = silence(*master, slave.node(), master_hung_at_);
    if (silent > detection_bound(i)) {
      report("I6: the master has heard nothing from " + slave.name() + " for " +
             std::to_string(silent) + " s on one connection and still holds on to it");
    }
  }
}

void Oracle::check_accounts(const ClusterStatus& status) {
  const TileAccounts& t = status.tiles;
  const auto text = [&] {
    return std::to_string(t.issued) + " issued, " + std::to_string(t.accepted) + " accepted, " +
           std::to_string(t.rejected) + " rejected, " + std::to_string(t.abandoned) +
           " abandoned, " + std::to_string(t.in_flight) + " in flight";
  };
  if (t.issued != t.accepted + t.rejected + t.abandoned + t.in_flight) {
    return report("I7: the account does not add up: " + text());
  }
  std::uint64_t held = 0;
  for (const SlaveStatus& slave : status.slaves) held += slave.tiles_in_flight;
  if (held != t.in_flight) {
    return report("I7: the slaves hold " + std::to_string(held) + " tiles: " + text());
  }
  if (leases_sent_ != t.issued) {
    return report("I7: " + std::to_string(leases_sent_) + " leases were sent: " + text());
  }
}

void Oracle::check_slaves(const ClusterStatus& status) {
  const double now = world_.queue.now_seconds();
  std::vector<bool> is_listed(watches_.size(), false);
  for (const SlaveStatus& slave : status.slaves) {
    const auto known = by_name_.find(slave.name);
    if (known == by_name_.end()) {
      check_bad_slave(slave);
      continue;
    }
    const std::size_t i = known->second;
    if (is_listed[i]) report("I7: two slaves are called " + slave.name);
    is_listed[i] = true;
    check_stall(i, slave);
    const auto tiles_max = static_cast<std::uint32_t>(kTilesPerWorkerMax * plan_.slaves[i].threads);
    if (slave.tiles_in_flight > tiles_max) {
      report("I4: " + slave.name + " holds " + std::to_string(slave.tiles_in_flight) + " tiles");
    }
    const double gone_since = watches_[i].gone_since;
    if (gone_since >= 0 && now > all_troubled_until_ && now > watches_[i].name_taken_until &&
        now - gone_since > detection_bound(i)) {
      report("I6: " + slave.name + " has been gone for " + std::to_string(now - gone_since) +
             " s and is still taken for alive");
    }
  }
  // A slave lost three times before it brings a tile is held back, as the fault matrix wants (F05).
  for (const QuarantinedSlave& held : status.quarantined) {
    const auto known = by_name_.find(held.name);
    if (known == by_name_.end()) continue;
    if (!held.reason.starts_with("lost "))
      report("I7: " + held.name + ", which is honest, is held back: " + held.reason);
    trouble_slave(known->second, now + held.seconds + return_bound_);
  }
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    if (is_healthy(i) && !is_listed[i]) {
      report(watches_[i].was_listed ? "I6: s" + std::to_string(i) + " is healthy and was given up"
                                    : "I6: s" + std::to_string(i) + " is healthy and not admitted");
    }
    if (is_listed[i] && !watches_[i].was_listed) watches_[i].listed_since = now;
    watches_[i].was_listed = is_listed[i];
    scenes_.check(i, is_listed[i], !is_healthy(i), now);
  }
}

void Oracle::check_bad_slave(const SlaveStatus& slave) {
  if (endings_.is_back_too_soon(slave.name, world_.queue.now_seconds()))
    report("I7: " + slave.name + " was found to lie, is held back, and is here");
  for (std::size_t i = 0; i < plan_.bad_slaves.size(); ++i) {
    const bool is_liar = plan_.bad_slaves[i].vice == Vice::kLies;
    if (is_liar && slave.name == name_of_bad_slave(i) && slave.tiles_done > 0)
      report("I7: lies of " + slave.name + " count as tiles");
  }
}

void Oracle::check_stall(std::size_t index, const SlaveStatus& slave) {
  Watch& watch = watches_[index];
  const double now = world_.queue.now_seconds();
  if (slave.state != SlaveState::kStalled) {
    watch.stalled_since = -1;
    return;
  }
  if (watch.stalled_since < 0) watch.stalled_since = now;
  const bool has_returned = watch.last_result > watch.stalled_since;
  if (has_returned && is_healthy(index) && now - watch.last_result > detection_bound(index))
    report("I7: " + slave.name + " has returned a tile and is still said to have stalled");
}

void Oracle::check_progress(const ClusterStatus& status) {
  const double now = world_.queue.now_seconds();
  bool is_due = world_.app.is_waiting() && !world_.app.is_hung() && !status.slaves.empty();
  bool has_healthy = false;
  for (std::size_t i = 0; i < watches_.size(); ++i) has_healthy = has_healthy || is_healthy(i);
  if (!is_due || !has_healthy) {
    last_progress_ = now;
  } else if (now - last_progress_ > progress_bound_) {
    report("I6: no frame for " + std::to_string(now - last_progress_) + " s, bound " +
           std::to_string(progress_bound_));
  }
}

bool Oracle::are_all_back() const {
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    const bool is_there =
        watches_[i].was_listed && world_.slaves[i]->is_running() && !world_.slaves[i]->is_leaving();
    if (!is_there) return false;
  }
  return true;
}

void Oracle::check_idle() {
  const ClusterStatus status = world_.master.loop().counts();
  if (status.tiles.in_flight != 0) {
    report("I7: " + std::to_string(status.tiles.in_flight) + " tiles in flight without a frame");
  }
  std::size_t running = 0;
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    running += world_.slaves[i]->is_running() ? 1u : 0u;
    const SimWorkshop* shop = world_.slaves[i]->workshop();
    const Process* const process = world_.slaves[i]->process();
    if (process != nullptr && world_.network.open_ends(*process) > kSlaveEndsMax) {
      report("I4: s" + std::to_string(i) + " holds " +
             std::to_string(world_.network.open_ends(*process)) + " connections");
    }
    if (shop != nullptr && shop->queued_tiles() + shop->working() > 0) {
      report("I4: s" + std::to_string(i) + " still renders when nothing is asked for");
    }
  }
  const std::size_t ends = world_.network.open_ends(*world_.master.process());
  if (ends > 2 * running) {
    report("I4: the master holds " + std::to_string(ends) + " connections to " +
           std::to_string(running) + " slaves and no application");
  }
}

}  // namespace tessera::sim
