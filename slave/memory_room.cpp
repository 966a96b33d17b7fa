#include "slave/memory_room.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace tessera::slave {
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

std::optional<std::uint64_t> number_in(const std::string& text) {
  if (text.empty() || text[0] < '0' || text[0] > '9') return std::nullopt;  // "max"
  return std::strtoull(text.c_str(), nullptr, 10);
}

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// Folder of our own memory control group: version 2 in one tree, version 1 in its own.
struct Group {
  std::string folder;
  bool is_v2 = false;
};
std::optional<Group> own_group() {
  std::istringstream lines(text_of("/proc/self/cgroup"));
  std::optional<Group> group;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t path = line.find(":/");
    if (path == std::string::npos) continue;
    if (line.find(":memory:") != std::string::npos) {
      return Group{"/sys/fs/cgroup/memory" + line.substr(path + 1), false};
    }
    if (line.compare(0, 3, "0::") == 0)
      group = Group{"/sys/fs/cgroup" + line.substr(path + 1), true};
  }
  return group;
}

}  // namespace

std::optional<MemoryRoom> memory_room(const MemoryTexts& texts, std::uint64_t cap_bytes) {
  const auto total = number_after(texts.meminfo, "MemTotal:");
  const auto available = number_after(texts.meminfo, "MemAvailable:");
  if (!total || !available) return std::nullopt;
  MemoryRoom room{*total * kKib, *available * kKib};
  if (const auto limit = number_in(texts.group_limit); limit && *limit < room.limit_bytes) {
    room.limit_bytes = *limit;
    // Pages of files go when memory is wanted.
    const std::uint64_t used = number_in(texts.group_usage).value_or(0);
    const std::uint64_t files = std::max(number_after(texts.group_stat, "inactive_file"),
                                         number_after(texts.group_stat, "total_inactive_file"))
                                    .value_or(0);
    const std::uint64_t kept = used - std::min(used, files);
    room.free_bytes = std::min(room.free_bytes, *limit - std::min(*limit, kept));
  }
  if (cap_bytes > 0 && cap_bytes < room.limit_bytes) {
    const std::uint64_t own = number_after(texts.own_status, "VmRSS:").value_or(0) * kKib;
    room.limit_bytes = cap_bytes;
    room.free_bytes = std::min(room.free_bytes, cap_bytes - std::min(cap_bytes, own));
  }
  return room;
}

std::optional<MemoryRoom> memory_room(std::uint64_t cap_bytes) {
  MemoryTexts texts;
  texts.meminfo = text_of("/proc/meminfo");
  texts.own_status = text_of("/proc/self/status");
  if (const auto group = own_group()) {
    texts.group_limit =
        text_of(group->folder + (group->is_v2 ? "/memory.max" : "/memory.limit_in_bytes"));
    texts.group_usage =
        text_of(group->folder + (group->is_v2 ? "/memory.current" : "/memory.usage_in_bytes"));
    texts.group_stat = text_of(group->folder + "/memory.stat");
  }
  return memory_room(texts, cap_bytes);
}

}  // namespace tessera::slave
