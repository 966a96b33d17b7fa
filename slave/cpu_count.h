// How many threads this process may keep busy: the CPUs that its affinity mask allows, cut by the CPU
// quota of its control group (containers), rounded up. At least 1, at most kWorkersMax.
//
// Threads. Any; reads files of /proc and /sys.
#pragma once

#include <optional>
#include <string_view>

namespace tessera::slave {

int usable_cpu_count();

// "max 100000" or "150000 100000", the text of cgroup v2's cpu.max. Returns: CPUs, rounded up; nothing when
// there is no limit or the text is not understood.
std::optional<int> parse_cpu_max(std::string_view text);

}  // namespace tessera::slave
