// SPDX-License-Identifier: Apache-2.0
// What the control groups of this process grant it: processor time and memory. A container's or a
// unit's limit stands in the process's own group or in any one above it, so all of them are read.
//
// cgroup v2: cpu.max, memory.max; v1: cpu.cfs_quota_us of the controller `cpu`,
// memory.limit_in_bytes of `memory`. Where both trees are there, the least of both counts.
//
// Threads. Any; each call reads a handful of small files and keeps nothing (a limit may change).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tessera {

// `root`, here and below: where /proc and /sys are looked for ("" outside of tests).

// Returns: the least of all limits of processor time, in processors; 0 when there is none or none
// can be read.
double cgroup_cpu_quota(const std::string& root = "");

// `limit_bytes` is the least of all limits. `free_bytes` is the least that any group has left below
// its limit; inactive pages of files, which are dropped when memory is wanted, count as left. The
// two may come from different groups: a large unit may be full of others' memory.
struct CgroupMemory {
  std::uint64_t limit_bytes = 0;
  std::uint64_t free_bytes = 0;
};
// Returns: nothing where no group has a limit or none can be read.
std::optional<CgroupMemory> cgroup_memory(const std::string& root = "");

}  // namespace tessera
