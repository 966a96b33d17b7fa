// SPDX-License-Identifier: Apache-2.0
#include "master/frame_loop/metrics_page.h"

#include <iterator>

#include "common/base/version.h"
#include "common/metrics/exposition.h"
#include "common/net/net_metrics.h"
#include "master/cluster/master_metrics.h"
#include "master/schedule/frame_ledger.h"

namespace tessera::master {
namespace {

using metrics::Exposition;
using metrics::Kind;

// Values of labels are words, never numbers that only the sources explain.
constexpr const char* kRefuseNames[] = {"version", "role",    "name", "isa",
                                        "busy",    "session", "full", "protocol"};
constexpr const char* kVerdictNames[] = {
    "accepted", "duplicate",   "confirmed",     "faulty",        "disputed",  "undecided",
    "repeated", "frame_ended", "unknown_frame", "wrong_version", "not_leased"};
static_assert(std::size(kRefuseNames) == MasterMetrics::kRefuseCodes);
static_assert(std::size(kVerdictNames) == MasterMetrics::kVerdicts);
static_assert(MasterMetrics::kVerdicts == kResultVerdicts);

void add_frames(Exposition& page, const ClusterStatus& status, const MasterMetrics& cells) {
  page.family("tessera_frames_total", Kind::kCounter, "Frames that ended, by how.")
      .sample({{"outcome", "done"}}, status.frames_done)
      .sample({{"outcome", "failed"}}, status.frames_failed)
      .sample({{"outcome", "cancelled"}}, status.frames_cancelled);
  page.family("tessera_frame_seconds", Kind::kHistogram, "From a frame's first lease to its end.")
      .histogram(cells.frame_seconds);
  page.family("tessera_tile_seconds", Kind::kHistogram, "Rendering of one tile, as slaves say.")
      .histogram(cells.tile_seconds);
  page.gauge("tessera_frames_open", "Frames submitted and not yet given back.", status.frames_open);
  page.gauge("tessera_application_present", "Whether an application is connected.",
             status.has_application ? 1 : 0);
}

void add_tiles(Exposition& page, const ClusterStatus& status, const MasterMetrics& cells) {
  const TileAccounts& tiles = status.tiles;
  page.counter("tessera_tiles_issued_total",
               "Leases. issued = accepted + rejected + abandoned + in flight.", tiles.issued);
  page.counter("tessera_tiles_accepted_total", "Leases whose result was used.", tiles.accepted);
  page.counter("tessera_tiles_rejected_total", "Leases whose result came second.", tiles.rejected);
  page.counter("tessera_tiles_abandoned_total", "Leases that ended without a result.",
               tiles.abandoned);
  page.gauge("tessera_tiles_in_flight", "Leases outstanding.",
             static_cast<double>(tiles.in_flight));
  page.counter("tessera_tiles_reissued_total", "Leases of tiles that were leased before.",
               status.tiles_reissued);
  page.family("tessera_results_total", Kind::kCounter, "Tile results received, by verdict.");
  for (std::size_t i = 0; i < MasterMetrics::kVerdicts; ++i)
    page.sample({{"verdict", kVerdictNames[i]}}, cells.results[i].value());
}

void add_cluster(Exposition& page, const ClusterStatus& status, const MasterMetrics& cells) {
  page.gauge("tessera_slaves", "Slaves that have joined and are there.",
             static_cast<double>(status.slaves.size()));
  page.counter("tessera_slaves_joined_total", "Sessions of slaves begun.",
               cells.slaves_joined.value());
  page.counter("tessera_slaves_lost_total", "Sessions of slaves ended.", cells.slaves_lost.value());
  page.counter("tessera_slave_reconnects_total", "Slaves that came back under their name.",
               cells.reconnects.value());
  page.family("tessera_refusals_total", Kind::kCounter, "Peers turned away, by reason.");
  for (std::size_t i = 0; i < MasterMetrics::kRefuseCodes; ++i)
    page.sample({{"reason", kRefuseNames[i]}}, cells.refusals[i].value());
  const net::NetMetrics& doors = net::net_metrics();
  page.family("tessera_connections_refused_total", Kind::kCounter,
              "Connections that ended before a peer was known, by reason.")
      .sample({{"reason", "handshake"}}, doors.handshakes_failed.value())
      .sample({{"reason", "crowded_out"}}, doors.crowded_out.value())
      .sample({{"reason", "over_rate"}}, doors.over_rate.value());
  page.counter("tessera_expulsions_total", "Slaves expelled for breaking the protocol.",
               cells.expulsions.value());
  page.gauge("tessera_quarantined_slaves", "Slaves that are held back for what they did.",
             static_cast<double>(status.quarantined.size()));
  page.family("tessera_net_loop_gap_seconds", Kind::kHistogram,
              "How late a task of the network thread came that is due every 10 ms.")
      .histogram(cells.loop_gap_seconds);
  page.counter("tessera_scene_bytes_sent_total", "Bytes of scene blocks sent to slaves.",
               cells.scene_bytes_sent.value());
}

// Adds one family with a sample for each slave. All such families have the same label, so that a
// dashboard joins them by it.
template <typename Value>
void add_for_each(Exposition& page, const ClusterStatus& status, const char* name, Kind kind,
                  const char* help, Value value) {
  page.family(name, kind, help);
  for (const SlaveStatus& slave : status.slaves) page.sample({{"slave", slave.name}}, value(slave));
}

void add_slaves(Exposition& page, const ClusterStatus& status) {
  const auto gauge = [&](const char* name, const char* help, auto value) {
    add_for_each(page, status, name, Kind::kGauge, help,
                 [&](const SlaveStatus& s) { return static_cast<double>(value(s)); });
  };
  const auto counter = [&](const char* name, const char* help, auto value) {
    add_for_each(page, status, name, Kind::kCounter, help, value);
  };
  using S = const SlaveStatus&;
  gauge("tessera_slave_threads", "Render threads.", [](S s) { return s.threads; });
  gauge("tessera_slave_utilisation_ratio",
        "Share of its threads' time spent rendering, last second.",
        [](S s) { return s.utilisation; });
  gauge("tessera_slave_rtt_seconds", "Round trip, smoothed.", [](S s) { return s.rtt_seconds; });
  gauge("tessera_slave_tile_rate", "Tiles accepted per second, last second.",
        [](S s) { return s.tiles_per_second; });
  gauge("tessera_slave_mean_tile_seconds", "Rendering of one of its tiles, moving average.",
        [](S s) { return s.tile_seconds; });
  gauge("tessera_slave_tiles_in_flight", "Leases outstanding.",
        [](S s) { return s.tiles_in_flight; });
  gauge("tessera_slave_prefetch_depth", "Tiles it may hold beyond those in work.",
        [](S s) { return s.prefetch_depth; });
  gauge("tessera_slave_scene_version", "Newest scene that it has built.",
        [](S s) { return s.scene_version; });
  gauge("tessera_slave_queue_bytes", "Bytes that wait in the master for its links.",
        [](S s) { return s.queue_bytes; });
  // Counters of the present session begin anew when a slave comes back, which a rate allows for.
  counter("tessera_slave_tiles_issued_total", "Leases of this session.",
          [](S s) { return s.tiles.issued; });
  counter("tessera_slave_tiles_accepted_total", "Leases of this session whose result was used.",
          [](S s) { return s.tiles.accepted; });
  counter("tessera_slave_tiles_rejected_total", "Leases of this session whose result came second.",
          [](S s) { return s.tiles.rejected; });
  counter("tessera_slave_tiles_abandoned_total", "Leases of this session without a result.",
          [](S s) { return s.tiles.abandoned; });
  counter("tessera_slave_sent_bytes_total", "Bytes sent to it in this session.",
          [](S s) { return s.bytes_sent; });
  counter("tessera_slave_received_bytes_total", "Bytes received from it in this session.",
          [](S s) { return s.bytes_received; });
}

}  // namespace

std::string metrics_page(const ClusterStatus& status) {
  const MasterMetrics& cells = master_metrics();
  Exposition page;
  page.family("tessera_build_info", Kind::kGauge, "1; the version is the label.")
      .sample({{"version", kBuildId}}, 1.0);
  add_cluster(page, status, cells);
  add_frames(page, status, cells);
  add_tiles(page, status, cells);
  add_slaves(page, status);
  metrics::add_process(page);
  return page.text();
}

}  // namespace tessera::master
