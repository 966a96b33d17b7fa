// SPDX-License-Identifier: Apache-2.0
// The commands of tessera-master. Each returns the process's exit code after printing at most one
// line of failure.
//
// Threads. Main thread; each call lives until the command is done.
#pragma once

#include "common/base/signal_watch.h"
#include "master/commands/options.h"

namespace tessera::master {

int run_serve(const MasterOptions& options, const SignalWatch& signals);
int run_view(const MasterOptions& options, const SignalWatch& signals);
int run_render(const MasterOptions& options, const SignalWatch& signals);
int run_status(const MasterOptions& options);

// Both print "tessera-master: MESSAGE" on stderr. Returns: 1; report_usage(), for what was found
// before work began, 2 for kInvalidArgument.
int report_failure(const Status& status);
int report_usage(const Status& status);

}  // namespace tessera::master
