// SPDX-License-Identifier: Apache-2.0
// How many render threads this process may run, and on which processors.
//
// Threads. Any; nothing is cached, since a container's quota may change. limit_cpus() must be
// called before other threads start, because they inherit the mask.
#pragma once

#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace tessera {

// The processors of the affinity mask, lowered to the container's quota (cgroup.h, rounded
// up); at least 1, at most kWorkersMax.
int available_cpu_count();

// The same count for a mask of `in_mask` processors and a quota; `quota` 0 means none.
int cpu_count_of(int in_mask, double quota);

// Numbers of the processors that this process may run on, ascending.
std::vector<int> allowed_cpus();

// Parses a choice of processors: "4" is the first four of `allowed`, "0-3,8" and "2-2" name them.
// Returns: kInvalidArgument, one line, for malformed text, for no processor at all, and for
// processors that are not in `allowed`.
Result<std::vector<int>> parse_cpus(std::string_view text, const std::vector<int>& allowed);

// Binds this process to these processors. Returns: kUnavailable with the system's reason.
Status limit_cpus(const std::vector<int>& cpus);

}  // namespace tessera
