// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <string>

#include "common/base/clean_text.h"
#include "common/base/json.h"
#include "common/base/log.h"
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
      .add("scene_port", std::uint32_t{slave.scene_port})
      .add("state", slave_state_name(slave.state))
      .add("ordinal", std::uint32_t{slave.ordinal})
      .add("prefetch_depth", slave.prefetch_depth)
      .add("tiles_per_second", slave.tiles_per_second)
      .add("tile_seconds", slave.tile_seconds)
      .add("tiles_issued", slave.tiles.issued)
      .add("tiles_accepted", slave.tiles.accepted)
      .add("tiles_rejected", slave.tiles.rejected)
      .add("tiles_abandoned", slave.tiles.abandoned)
      .add("queue_bytes", slave.queue_bytes)
      .add("bytes_sent", slave.bytes_sent)
      .add("bytes_received", slave.bytes_received);
  return json.text();
}

std::string events_json(const std::vector<PastEvent>& events) {
  std::string all = "[";
  for (const PastEvent& event : events) {
    if (all.size() > 1) all += ',';
    JsonObject json;
    json.add("seconds_ago", event.seconds_ago)
        .add("level", log_level_name(static_cast<LogLevel>(event.level)))
        .add("line", event.line);
    all += json.text();
  }
  return all + "]";
}

std::string suppressed_json(const std::vector<SuppressedLines>& suppressed) {
  JsonObject json;
  for (const SuppressedLines& lines : suppressed) json.add(lines.event, lines.lines);
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
      .add("tiles_reissued", status.tiles_reissued)
      .add("frames_failed", status.frames_failed)
      .add("frames_cancelled", status.frames_cancelled)
      .add("frames_open", std::uint64_t{status.frames_open})
      .add("slaves_lost", status.slaves_lost)
      .add("alone_reason", status.alone_reason)
      .add_raw("events", events_json(status.events))
      .add_raw("lines_suppressed", suppressed_json(status.suppressed))
      .add_raw("slaves", slaves + "]")
      .add_raw("quarantined", quarantined + "]");
  std::printf("%s\n", json.text().c_str());
}

double share_of(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

// "987", "12.3k", "4.56M": what fits a narrow column.
std::string short_count(double value) {
  static constexpr const char* kUnits[] = {"", "k", "M", "G", "T"};
  int unit = 0;
  for (; value >= 1000 && unit < 4; ++unit) value /= 1000;
  char text[32];
  std::snprintf(text, sizeof(text), unit == 0 || value >= 100 ? "%.0f%s" : "%.3g%s", value,
                kUnits[unit]);
  return text;
}

void print_totals(const ClusterStatus& status) {
  using ull = unsigned long long;
  std::printf(
      "%zu slave%s, %s; frames: %llu done, %llu failed, %llu cancelled; slaves lost: %llu\n",
      status.slaves.size(), status.slaves.size() == 1 ? "" : "s",
      status.has_application ? "an application is connected" : "no application",
      ull{status.frames_done}, ull{status.frames_failed}, ull{status.frames_cancelled},
      ull{status.slaves_lost});
  const TileAccounts& t = status.tiles;
  std::printf(
      "tiles: %llu issued = %llu accepted + %llu rejected + %llu abandoned + %llu in flight; "
      "%llu issued again (%.2f%%)\n",
      ull{t.issued}, ull{t.accepted}, ull{t.rejected}, ull{t.abandoned}, ull{t.in_flight},
      ull{status.tiles_reissued}, share_of(status.tiles_reissued, t.issued));
}

void print_suppressed(const ClusterStatus& status) {
  if (status.suppressed.empty()) return;
  std::string text;
  for (const SuppressedLines& lines : status.suppressed)
    text +=
        (text.empty() ? "" : ", ") + clean_text(lines.event) + " " + std::to_string(lines.lines);
  std::printf("lines of the log that were only counted: %s\n", text.c_str());
}

void print_events(const ClusterStatus& status) {
  for (const PastEvent& event : status.events) {
    std::printf("%8.1f s ago %-5s %s\n", event.seconds_ago,
                std::string(log_level_name(static_cast<LogLevel>(event.level))).c_str(),
                clean_text(event.line).c_str());
  }
}

void print_table(const ClusterStatus& status) {
  print_totals(status);
  print_suppressed(status);
  if (!status.alone_reason.empty())
    std::printf("no slave is heard: %s\n", clean_text(status.alone_reason).c_str());
  for (const QuarantinedSlave& slave : status.quarantined) {
    std::printf("held back for %.0f s more: %s (%s)\n", slave.seconds,
                clean_text(slave.name).c_str(), clean_text(slave.reason).c_str());
  }
  if (status.slaves.empty()) return;
  std::size_t name_width = 5;
  for (const SlaveStatus& s : status.slaves) name_width = std::max(name_width, s.name.size());
  const int width = static_cast<int>(name_width);
  std::printf("%-*s %-11s %7s %-6s %5s %8s %8s %8s %5s %5s %5s %8s %8s %8s\n", width, "slave",
              "state", "threads", "isa", "busy", "tiles/s", "tile ms", "rtt ms", "held", "ahead",
              "scene", "accepted", "rejected", "lost");
  for (const SlaveStatus& s : status.slaves) {
    const auto count = [](std::uint64_t n) { return short_count(static_cast<double>(n)); };
    std::printf("%-*s %-11s %7u %-6s %4.0f%% %8s %8.2f %8.2f %5u %5u %5s %8s %8s %8s\n", width,
                clean_text(s.name).c_str(), std::string(slave_state_name(s.state)).c_str(),
                s.threads, std::string(isa_name(s.isa)).c_str(), 100 * s.utilisation,
                short_count(s.tiles_per_second).c_str(), 1e3 * s.tile_seconds, 1e3 * s.rtt_seconds,
                s.tiles_in_flight, s.prefetch_depth, count(s.scene_version).c_str(),
                count(s.tiles.accepted).c_str(), count(s.tiles.rejected).c_str(),
                count(s.tiles.abandoned).c_str());
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
    if (options.has_events) print_events(*status);
  }
  return 0;
}

}  // namespace tessera::master
