// SPDX-License-Identifier: Apache-2.0
// How sessions of slaves end, what that says of the slave, and how a process is known again.
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/log.h"
#include "master/cluster/cluster.h"
#include "master/cluster/master_metrics.h"

namespace tessera::master {

void Cluster::expel(SessionId session, const std::string& reason) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return;
  master_metrics().expulsions.add();
  SlaveEntry& liar = *slave->second;
  const std::string& key = key_of(liar.hello, liar.tile_link->connection().peer());
  quarantine_.count_violation(key, reason, Clock::now());
  liar.tile_link->refuse(wire::RefuseCode::kProtocol, reason);
  log_warn("slave-lost", "slave '" + liar.hello.name + "' was expelled",
           {{"reason", "expelled: " + reason},
            {"peer", liar.tile_link->connection().peer().address},
            {"held_back_s",
             std::to_string(std::llround(quarantine_.find(key, Clock::now())->seconds))}});
  remove(session, SlaveEnd::kExpelled);
  cause_.lost(LossKind::kOther, slave_count(), Clock::now());
}

// The process may be one that lost its link: then its losses are none of its own, and a session
// that still stands for it is over.
void Cluster::welcome_back(const wire::Hello& hello, const net::PeerIdentity& peer) {
  if (hello.instance == 0) return;
  const auto old = std::find_if(slaves_.begin(), slaves_.end(), [&](const auto& entry) {
    const SlaveEntry& slave = *entry.second;
    return slave.hello.instance == hello.instance && slave.hello.name == hello.name &&
           key_of(slave.hello, slave.tile_link->connection().peer()) == key_of(hello, peer);
  });
  if (old != slaves_.end()) lose(old->first, "its process is here with a new link");
  quarantine_.forget_losses(key_of(hello, peer), hello.instance, Clock::now());
}

void Cluster::convict(const std::string& slave, const std::string& reason) {
  const auto here = std::find_if(slaves_.begin(), slaves_.end(), [&](const auto& entry) {
    return key_of(entry.second->hello, entry.second->tile_link->connection().peer()) == slave;
  });
  if (here != slaves_.end()) return expel(here->first, reason);
  const TimePoint now = Clock::now();
  quarantine_.count_violation(slave, reason, now);
  log_warn("slave-quarantined", "slave '" + slave + "', which is gone, is held back: " + reason,
           {{"held_back_s", std::to_string(std::llround(quarantine_.find(slave, now)->seconds))}});
}

void Cluster::suspect(const std::string& slave, const std::string& reason) {
  if (quarantine_.count_wrong(slave, Clock::now()))
    convict(slave, std::to_string(Quarantine::kWrongMax) + " tiles within a minute with " + reason);
}

LossKind Cluster::kind_of(SessionId session, const Status& end, bool is_tile_link) const {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return LossKind::kOther;
  if (end.code() != StatusCode::kDeadlineExceeded) return LossKind::kOther;
  const auto& link = is_tile_link ? slave->second->tile_link : slave->second->scene_link;
  switch (link->silence()) {
    case Silence::kWhole:
      return LossKind::kSilent;
    case Silence::kOneWay:
      return LossKind::kUnheard;
    case Silence::kOfProcess:
      break;
  }
  return LossKind::kOther;
}

void Cluster::lose(SessionId session, const std::string& reason, LossKind kind) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return;
  const SlaveEntry& gone = *slave->second;
  const net::PeerIdentity& peer = gone.tile_link->connection().peer();
  const TimePoint now = Clock::now();
  const std::uint32_t held = events_.tiles_held ? events_.tiles_held(session) : 0;
  log_warn("slave-lost", "slave '" + gone.hello.name + "' is gone",
           {{"reason", reason}, {"peer", peer.address}, {"tiles_held", std::to_string(held)}});
  const std::string& key = key_of(gone.hello, peer);
  if (quarantine_.count_loss(key, gone.hello.instance, gone.tiles_done, held, now)) {
    const QuarantinedSlave why = *quarantine_.find(key, now);
    log_warn("slave-quarantined", "slave '" + gone.hello.name + "' is held back: " + why.reason,
             {{"held_back_s", std::to_string(std::llround(why.seconds))}});
  }
  const bool has_joined = gone.is_joined();
  remove(session, SlaveEnd::kLost);
  if (has_joined && cause_.lost(kind, slave_count(), now)) log_error("nobody-heard", cause_.text());
}

void Cluster::leave(SessionId session, const std::string& reason) {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end()) return;
  log_info("slave-left", "slave '" + slave->second->hello.name + "' said goodbye",
           {{"reason", reason}});
  remove(session, SlaveEnd::kLeft);
  cause_.lost(LossKind::kOther, slave_count(), Clock::now());
}

void Cluster::remove(SessionId session, SlaveEnd how) {
  const auto found = slaves_.find(session);
  const std::shared_ptr<SlaveEntry> slave = std::move(found->second);
  slaves_.erase(found);
  std::erase_if(open_frames_, [&](const auto& open) { return open.first == session; });
  for (PeerLink* link : {slave->tile_link.get(), slave->scene_link.get()}) {
    if (link == nullptr) continue;
    gone_bytes_sent_ += link->connection().bytes_sent();
    gone_bytes_received_ += link->connection().bytes_received();
    link->close();
  }
  if (slave->scene_link) gone_scene_bytes_sent_ += slave->scene_link->connection().bytes_sent();
  io_.post([slave] {});  // one of its callbacks may be running
  apply(relay_.lost(session, Clock::now()));
  if (!slave->is_joined()) return;
  master_metrics().slaves_lost.add();
  events_.slave_lost(session, how);
}

}  // namespace tessera::master
