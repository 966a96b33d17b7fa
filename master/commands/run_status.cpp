#include <cstdio>

#include "common/base/json.h"
#include "master/commands/commands.h"
#include "master/session/remote_session.h"

namespace tessera::master {
namespace {

std::string slave_json(const SlaveStatus& slave) {
  JsonObject json;
  json.add("name", slave.name)
      .add("threads", slave.threads)
      .add("isa", isa_name(slave.isa))
      .add("tiles_in_flight", slave.tiles_in_flight)
      .add("tiles_done", slave.tiles_done)
      .add("utilisation", slave.utilisation)
      .add("rtt_seconds", slave.rtt_seconds)
      .add("scene_version", slave.scene_version)
      .add("tile_port", std::uint32_t{slave.tile_port})
      .add("scene_port", std::uint32_t{slave.scene_port});
  return json.text();
}

void print_json(const ClusterStatus& status) {
  std::string slaves = "[";
  for (const SlaveStatus& slave : status.slaves) {
    if (slaves.size() > 1) slaves += ',';
    slaves += slave_json(slave);
  }
  std::string quarantined = "[";
  for (const QuarantinedSlave& slave : status.quarantined) {
    if (quarantined.size() > 1) quarantined += ',';
    JsonObject entry;
    entry.add("name", slave.name)
        .add("seconds", slave.seconds)
        .add("times", slave.times)
        .add("reason", slave.reason);
    quarantined += entry.text();
  }
  const ClusterPace& pace = status.pace;
  const TileAccounts& tiles = status.tiles;
  JsonObject json;
  json.add("frames_done", status.frames_done)
      .add("has_application", status.has_application)
      .add("heartbeat_ms", pace.heartbeat_ms)
      .add("heartbeats_missed_max", pace.heartbeats_missed_max)
      .add("handshake_ms", pace.handshake_ms)
      .add("reconnect_max_ms", pace.reconnect_max_ms)
      .add("rtt_seconds_max", pace.rtt_seconds_max)
      .add("tile_seconds_median", pace.tile_seconds_median)
      .add("tile_seconds_p95", pace.tile_seconds_p95)
      .add("tiles_issued", tiles.issued)
      .add("tiles_accepted", tiles.accepted)
      .add("tiles_rejected", tiles.rejected)
      .add("tiles_abandoned", tiles.abandoned)
      .add("tiles_in_flight", tiles.in_flight)
      .add_raw("slaves", slaves + "]")
      .add_raw("quarantined", quarantined + "]");
  std::printf("%s\n", json.text().c_str());
}

void print_table(const ClusterStatus& status) {
  std::printf("%zu slaves, %llu frames done, %s\n", status.slaves.size(),
              static_cast<unsigned long long>(status.frames_done),
              status.has_application ? "an application is connected" : "no application");
  for (const QuarantinedSlave& slave : status.quarantined) {
    std::printf("held back for %.0f s more: %s (%s)\n", slave.seconds, slave.name.c_str(),
                slave.reason.c_str());
  }
  if (status.slaves.empty()) return;
  std::printf("%-24s %7s %-7s %6s %9s %5s %8s %6s %6s\n", "name", "threads", "isa", "queued",
              "done", "busy", "rtt ms", "tiles", "scene");
  for (const SlaveStatus& s : status.slaves) {
    std::printf("%-24s %7u %-7s %6u %9llu %4.0f%% %8.2f %6u %6u\n", s.name.c_str(), s.threads,
                std::string(isa_name(s.isa)).c_str(), s.tiles_in_flight,
                static_cast<unsigned long long>(s.tiles_done), 100 * s.utilisation,
                1e3 * s.rtt_seconds, s.tile_port, s.scene_port);
  }
}

}  // namespace

int run_status(const MasterOptions& options) {
  auto status = fetch_status(options.session);
  if (!status.is_ok()) return report_failure(status.status());
  if (options.is_json) {
    print_json(*status);
  } else {
    print_table(*status);
  }
  return 0;
}

}  // namespace tessera::master
