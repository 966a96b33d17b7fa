// SPDX-License-Identifier: Apache-2.0
#include "common/base/memory_room.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace tessera {
namespace {

constexpr std::uint64_t kKib = 1024;

// The number behind `key`, in lines of "key: number" or "key number".
std::optional<std::uint64_t> number_after(const std::string& text, const std::string& key) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.compare(0, key.size(), key) != 0) continue;
    const std::size_t digits = line.find_first_of("0123456789", key.size());
    if (digits == std::string::npos) return std::nullopt;
    return std::strtoull(line.c_str() + digits, nullptr, 10);
  }
  return std::nullopt;
}

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

std::optional<MemoryRoom> memory_room(const MemoryTexts& texts,
                                      const std::optional<CgroupMemory>& group,
                                      std::uint64_t cap_bytes) {
  const auto total = number_after(texts.meminfo, "MemTotal:");
  const auto available = number_after(texts.meminfo, "MemAvailable:");
  if (!total || !available) return std::nullopt;
  MemoryRoom room{*total * kKib, *available * kKib};
  if (group) {
    room.limit_bytes = std::min(room.limit_bytes, group->limit_bytes);
    room.free_bytes = std::min(room.free_bytes, group->free_bytes);
  }
  if (cap_bytes > 0 && cap_bytes < room.limit_bytes) {
    const std::uint64_t own = number_after(texts.own_status, "VmRSS:").value_or(0) * kKib;
    room.limit_bytes = cap_bytes;
    room.free_bytes = std::min(room.free_bytes, cap_bytes - std::min(cap_bytes, own));
  }
  return room;
}

std::optional<MemoryRoom> memory_room(std::uint64_t cap_bytes) {
  return memory_room({text_of("/proc/meminfo"), text_of("/proc/self/status")}, cgroup_memory(),
                     cap_bytes);
}

}  // namespace tessera
