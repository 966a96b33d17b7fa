// How many render threads this process may run.
// Threads. Any; nothing is cached, since a container's quota may change.
#pragma once

namespace tessera {

// The affinity mask's count, lowered to the container's CPU quota (cgroup v2 cpu.max, v1
// cpu.cfs_quota_us, rounded up); at least 1, at most kWorkersMax. Any thread; reads /proc and /sys.
int available_cpu_count();

}  // namespace tessera
