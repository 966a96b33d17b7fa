// SPDX-License-Identifier: Apache-2.0
// What a master counts of itself, as cells for the page of metrics. There is one set for a process,
// since a scraper looks at processes, and counts only rise.
//
// What is known of each slave and of the frames is not here; it is written from ClusterStatus when
// somebody scrapes (frame_loop/metrics_page.h).
//
// Threads. Any; see common/metrics/cells.h.
#pragma once

#include <array>

#include "common/metrics/cells.h"

namespace tessera::master {

struct MasterMetrics {
  static constexpr std::size_t kRefuseCodes = 8;  // as wire::RefuseCode
  static constexpr std::size_t kVerdicts = 11;    // as ResultVerdict

  std::array<metrics::Counter, kRefuseCodes> refusals;  // handshakes and sessions, by code
  std::array<metrics::Counter, kVerdicts> results;      // tile results, by verdict
  metrics::Counter expulsions;                          // slaves that broke the protocol
  metrics::Counter slaves_joined, slaves_lost;
  metrics::Counter reconnects;  // joined under a name that was here before
  metrics::Counter scene_bytes_sent;
  metrics::Histogram frame_seconds{metrics::kSecondsBounds};     // first lease to last result
  metrics::Histogram loop_gap_seconds{metrics::kSecondsBounds};  // as LoopGap says
  metrics::Histogram tile_seconds{metrics::kSecondsBounds};      // rendering alone
};

MasterMetrics& master_metrics();

}  // namespace tessera::master
