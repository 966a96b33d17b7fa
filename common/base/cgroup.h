// SPDX-License-Identifier: Apache-2.0
// What the control groups of this process grant it: processor time and memory. A container's or a
// unit's limit stands in the process's own group or in any one above it, so all of them are read.
//
// cgroup v2: cpu.max, memory.max; v1: cpu.cfs_quota_us of the controller `cpu`,
// memory.limit_in_bytes of `memory`. Where both trees are there, the least of both.
//
// Threads. Any; each call reads a handful of small files, nothing is kept (a limit may change).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tessera {

// `root`, here and below: where /proc and /sys are looked for ("" outside of tests).

// Processors' worth of time, the least of all limits found; 0 when there is none or nothing can be
// told.
double cgroup_cpu_quota(const std::string& root = "");

// In bytes. `limit`: the least of all limits. `free`: the least that any group has left below its
// limit, where pages of files, which go when memory is wanted, count as left. The two may be of
// different groups: a large unit may be full of others' memory.
struct CgroupMemory {
  std::uint64_t limit_bytes = 0;
  std::uint64_t free_bytes = 0;
};
// Returns: nothing where no group has a limit or nothing can be told.
std::optional<CgroupMemory> cgroup_memory(const std::string& root = "");

}  // namespace tessera
