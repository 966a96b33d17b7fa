// SPDX-License-Identifier: Apache-2.0
// The commands of tessera-master. Each returns the process's exit code after printing at most one
// line of failure; render, where frames failed and the others are there, one for each of these.
// Exit codes: 0 done, 1 failed, 2 wrong words, 3 some frames failed.
//
// Threads. Main thread; each call lives until the command is done.
#pragma once

#include <string>

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
// Prints the frames that failed while others did not have to. Returns: 3.
int report_failed_frames(const std::string& lines);

}  // namespace tessera::master
