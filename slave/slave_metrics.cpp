// SPDX-License-Identifier: Apache-2.0
#include "slave/slave_metrics.h"

#include "common/base/version.h"
#include "common/metrics/exposition.h"

namespace tessera::slave {

SlaveMetrics& slave_metrics() {
  static SlaveMetrics cells;
  return cells;
}

std::string metrics_page(int threads) {
  using metrics::Kind;
  const SlaveMetrics& cells = slave_metrics();
  metrics::Exposition page;
  page.family("tessera_build_info", Kind::kGauge, "1; the version is the label.")
      .sample({{"version", kBuildId}}, 1.0);
  page.gauge("tessera_render_connected", "Whether the slave has a session with its master.",
             cells.is_connected.value());
  page.counter("tessera_render_sessions_total", "Sessions begun; more than one: reconnects.",
               cells.sessions.value());
  page.gauge("tessera_render_threads", "Render threads.", threads);
  page.family("tessera_render_tile_seconds", Kind::kHistogram, "Rendering of one tile.")
      .histogram(cells.tile_seconds);
  page.family("tessera_render_rays_total", Kind::kCounter, "Rays traced.")
      .sample({{"kind", "primary"}}, cells.rays_primary.value())
      .sample({{"kind", "shadow"}}, cells.rays_shadow.value())
      .sample({{"kind", "secondary"}}, cells.rays_secondary.value());
  page.family("tessera_render_starved_seconds_total", Kind::kCounter,
              "Time of render threads without a tile while a frame was open.")
      .sample(cells.starved_seconds.value());
  page.family("tessera_render_build_seconds", Kind::kHistogram, "Build of one scene.")
      .histogram(cells.build_seconds);
  metrics::add_process(page);
  return page.text();
}

}  // namespace tessera::slave
