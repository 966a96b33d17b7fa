// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "common/base/heap.h"
#include "master/commands/commands.h"
#include "master/session/master_host.h"

namespace tessera::master {

int run_serve(const MasterOptions& options, const SignalWatch& signals) {
  give_large_blocks_back();  // lists of chunks have up to 4 MiB
  auto host = MasterHost::start(options.session, /*serves_applications=*/true);
  if (!host.is_ok()) return report_failure(host.status());
  while (!signals.wait(std::chrono::milliseconds(60'000))) {
  }
  log_info("ending", "said goodbye to every peer");
  return 0;
}

}  // namespace tessera::master
