// SPDX-License-Identifier: Apache-2.0
// What a slave counts of itself, and its page of metrics. One set for a process: in a master's
// process with slaves inside, they share it (and nobody serves the page).
//
// Threads. Any; see common/metrics/cells.h.
#pragma once

#include <string>

#include "common/metrics/cells.h"

namespace tessera::slave {

struct SlaveMetrics {
  metrics::Counter rays_primary, rays_shadow, rays_secondary;
  metrics::Histogram tile_seconds{metrics::kSecondsBounds};
  metrics::Sum starved_seconds;  // of render threads, waiting while a frame was open
  metrics::Histogram build_seconds{metrics::kSecondsBounds};
  metrics::Counter sessions;  // joined, from the first one on
  metrics::Gauge is_connected;
};

SlaveMetrics& slave_metrics();

std::string metrics_page(int threads);

}  // namespace tessera::slave
