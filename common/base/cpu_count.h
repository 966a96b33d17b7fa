// How many render threads this process may run.
#pragma once

namespace tessera {

// The affinity mask's count, lowered to the container's CPU quota (cgroup v2 cpu.max, v1
// cpu.cfs_quota_us, rounded up); at least 1, at most kWorkersMax. Any thread; reads /proc and /sys.
int available_cpu_count();

}  // namespace tessera
