// How much memory a slave may take: what the machine has, what its container or unit allows
// (control groups, both versions), and what the person said with --memory.
//
// Threads. Any. The texts of the kernel's files are read afresh with each call.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tessera::slave {

// In bytes. `limit`: in all; `free`: that can be had now, without what others use.
struct MemoryRoom {
  std::uint64_t limit_bytes = 0;
  std::uint64_t free_bytes = 0;
};

// The texts of /proc/meminfo, and of one control group's limit, usage and memory.stat (empty:
// no such file). Returns: nothing when meminfo cannot be read.
struct MemoryTexts {
  std::string meminfo, group_limit, group_usage, group_stat, own_status;
};
std::optional<MemoryRoom> memory_room(const MemoryTexts& texts, std::uint64_t cap_bytes);

// Of this process. `cap_bytes` 0: no cap.
std::optional<MemoryRoom> memory_room(std::uint64_t cap_bytes);

}  // namespace tessera::slave
