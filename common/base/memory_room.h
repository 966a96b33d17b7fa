// SPDX-License-Identifier: Apache-2.0
// How much memory a process may take: what the machine has, what its container or unit allows
// (control groups, both versions), and what the person said with --memory.
//
// Threads. Any. The texts of the kernel's files are read afresh with each call.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/cgroup.h"

namespace tessera {

// limit_bytes: in all; free_bytes: what can be had now, without what others use.
struct MemoryRoom {
  std::uint64_t limit_bytes = 0;
  std::uint64_t free_bytes = 0;
};

// The texts of /proc/meminfo and /proc/self/status.
struct MemoryTexts {
  std::string meminfo, own_status;
};
// `group`: what the control groups allow, nothing for no limit. Returns: nothing when meminfo
// cannot be read.
std::optional<MemoryRoom> memory_room(const MemoryTexts& texts,
                                      const std::optional<CgroupMemory>& group,
                                      std::uint64_t cap_bytes);

// The room of this process. `cap_bytes` 0: no cap.
std::optional<MemoryRoom> memory_room(std::uint64_t cap_bytes);

}  // namespace tessera
