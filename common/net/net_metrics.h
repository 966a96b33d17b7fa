// SPDX-License-Identifier: Apache-2.0
// What a process counts of peers that it did not let in, for its page of metrics. Counts only rise.
//
// Threads. Any; see common/metrics/cells.h.
#pragma once

#include "common/metrics/cells.h"

namespace tessera::net {

struct NetMetrics {
  metrics::Counter handshakes_failed;  // wrong or no credentials, garbage, too slow
  metrics::Counter crowded_out;        // unauthenticated, and too many of them
  metrics::Counter over_rate;          // from an address that opens connections too fast
};

inline NetMetrics& net_metrics() {
  static NetMetrics cells;
  return cells;
}

}  // namespace tessera::net
