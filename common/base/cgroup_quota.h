// How much processor time the control groups of this process grant it. A container's limit stands
// in the process's own group or in any one above it, so all of them are read.
//
// Threads. Any; reads a handful of small files, caches nothing (a quota may change).
#pragma once

#include <string>

namespace tessera {

// Processors' worth of time, the least of all limits found; 0 when there is none or nothing can be
// told. cgroup v2: cpu.max; v1: cpu.cfs_quota_us of the controller `cpu`. `root`: where /proc and
// /sys are looked for ("" outside of tests).
double cgroup_cpu_quota(const std::string& root = "");

}  // namespace tessera
