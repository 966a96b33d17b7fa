// SPDX-License-Identifier: Apache-2.0
// How fast the master hands out tiles and takes them back: its real frame loop, cluster and links
// on their network thread, against slaves that answer at once, beside a bare epoll loop that does
// the same exchange (6 KiB result, 64-byte request, one thread, as many connections) in the same
// run. Figures and what was tried: README.md beside this.
//
// Threads. One; it makes the master's.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera::bench {

struct ExchangeOptions {
  std::vector<int> connections;  // empty: 8, 64, 500
  int threads = 4;               // of each slave: 16 tiles out at a time
  double seconds = 5;            // measured, after one to warm up
  double minutes = 0;            // > 0: only the master's memory, minute by minute, for so long
  std::string link = "both";     // plain, tls: one alone, for a profile
};

// Appends one JSON object per row.
Status run_exchange_suite(const ExchangeOptions& options, std::vector<std::string>& rows);

}  // namespace tessera::bench
