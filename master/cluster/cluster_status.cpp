// SPDX-License-Identifier: Apache-2.0
// What a cluster tells of itself: its status, its pace and its sums.
#include <algorithm>
#include <utility>

#include "common/base/limits.h"
#include "master/cluster/cluster.h"

namespace tessera::master {

std::vector<QuarantinedSlave> Cluster::quarantined() const {
  return quarantine_.entries(Clock::now());
}

ClusterPace Cluster::pace() const {
  ClusterPace pace;
  pace.heartbeat_ms = pulse_.heartbeat_ms;
  pace.heartbeats_missed_max = pulse_.missed_max;
  pace.handshake_ms = kHandshakeMs;
  pace.reconnect_max_ms = kReconnectMaxMs;
  std::vector<double> all;
  for (const auto& [session, slave] : slaves_) {
    const std::vector<double>& times = slave->tile_times.seconds();
    all.insert(all.end(), times.begin(), times.end());
    pace.tile_seconds_p95 = std::max(pace.tile_seconds_p95, quantile(times, 0.95));
    pace.heartbeat_ms = std::max(pace.heartbeat_ms, slave->pulse.heartbeat_ms);
    pace.rtt_seconds_max = std::max(pace.rtt_seconds_max, slave->tile_link->rtt_seconds());
  }
  pace.tile_seconds_median = quantile(std::move(all), 0.5);
  return pace;
}

std::vector<SlaveStatus> Cluster::status(
    const std::function<void(SessionId, SlaveStatus&)>& complete) const {
  std::vector<SlaveStatus> result;
  for (const auto& [session, slave] : slaves_) {
    if (!slave->is_joined()) continue;
    SlaveStatus status;
    status.name = slave->hello.name;
    status.threads = slave->hello.threads;
    status.isa = widest_isa(slave->hello.isas);
    status.tiles_done = slave->tiles_done;
    status.utilisation = slave->utilisation;
    status.rtt_seconds = slave->tile_link->rtt_seconds();
    status.scene_version = slave->built;
    status.tile_port = slave->tile_link->connection().peer().port;
    status.scene_port = slave->scene_link->connection().peer().port;
    status.ordinal = slave->ordinal;
    const bool is_waiting = !scenes_.empty() && slave->built < scenes_.rbegin()->first;
    status.state = is_waiting ? SlaveState::kWaiting : SlaveState::kReady;
    status.tiles_per_second = slave->tiles_per_second;
    for (const PeerLink* link : {slave->tile_link.get(), slave->scene_link.get()}) {
      status.queue_bytes += link->connection().queue_bytes();
      status.bytes_sent += link->connection().bytes_sent();
      status.bytes_received += link->connection().bytes_received();
    }
    complete(session, status);
    result.push_back(std::move(status));
  }
  std::sort(result.begin(), result.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return result;
}

std::uint64_t Cluster::bytes_sent() const {
  std::uint64_t bytes = gone_bytes_sent_;
  for (const auto& [session, slave] : slaves_) {
    bytes += slave->tile_link->connection().bytes_sent();
    if (slave->is_joined()) bytes += slave->scene_link->connection().bytes_sent();
  }
  return bytes;
}

std::uint64_t Cluster::scene_bytes_sent() const {
  std::uint64_t bytes = gone_scene_bytes_sent_;
  for (const auto& [session, slave] : slaves_) {
    if (slave->is_joined()) bytes += slave->scene_link->connection().bytes_sent();
  }
  return bytes;
}

std::uint64_t Cluster::bytes_received() const {
  std::uint64_t bytes = gone_bytes_received_;
  for (const auto& [session, slave] : slaves_) {
    bytes += slave->tile_link->connection().bytes_received();
    if (slave->is_joined()) bytes += slave->scene_link->connection().bytes_received();
  }
  return bytes;
}

std::uint32_t Cluster::thread_count() const {
  std::uint32_t count = 0;
  for (const auto& [session, slave] : slaves_)
    count += slave->is_joined() ? slave->hello.threads : 0;
  return count;
}

std::uint32_t Cluster::threads_of(SessionId session) const {
  const auto slave = slaves_.find(session);
  return slave == slaves_.end() ? 0 : slave->second->hello.threads;
}

std::optional<ClockEstimate> Cluster::clock_of(SessionId session, TimePoint now) const {
  const auto slave = slaves_.find(session);
  if (slave == slaves_.end() || !slave->second->is_joined()) return std::nullopt;
  return better(slave->second->tile_link->clock(now), slave->second->scene_link->clock(now));
}

std::vector<SessionId> Cluster::joined_sessions() const {
  std::vector<SessionId> sessions;
  for (const auto& [session, slave] : slaves_) {
    if (slave->is_joined()) sessions.push_back(session);
  }
  return sessions;
}

}  // namespace tessera::master
