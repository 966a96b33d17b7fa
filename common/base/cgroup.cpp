// SPDX-License-Identifier: Apache-2.0
#include "common/base/cgroup.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <initializer_list>
#include <sstream>
#include <string_view>

namespace tessera {
namespace {

constexpr int kGroupsDeepMax = 64;
constexpr double kQuotaMax = 1e6;  // bounds the quota of a file that says infinity

template <typename Number>
std::optional<Number> number_of(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

template <typename Number>
std::optional<Number> number_in(const std::string& path) {
  std::ifstream file(path);
  std::string word;
  if (!(file >> word)) return std::nullopt;
  return number_of<Number>(word);
}

// cpu.max of v2 holds "max 100000" or "150000 100000".
std::optional<double> quota_v2(const std::string& folder) {
  std::ifstream file(folder + "/cpu.max");
  std::string quota, period;
  if (!(file >> quota >> period)) return std::nullopt;
  const auto q = number_of<double>(quota), p = number_of<double>(period);
  if (!q || !p || !(*q > 0) || !(*p > 0)) return std::nullopt;  // "max", NaN
  return std::min(*q / *p, kQuotaMax);
}

// The quota file of v1 holds -1 where there is no limit.
std::optional<double> quota_v1(const std::string& folder) {
  const auto quota = number_in<double>(folder + "/cpu.cfs_quota_us");
  const auto period = number_in<double>(folder + "/cpu.cfs_period_us");
  if (!quota || !period || !(*quota > 0) || !(*period > 0)) return std::nullopt;
  return std::min(*quota / *period, kQuotaMax);
}

// The number of that key in memory.stat, lines of "key number".
std::uint64_t stat_of(const std::string& folder, const std::string& key) {
  std::ifstream file(folder + "/memory.stat");
  std::uint64_t value = 0;
  for (std::string name; file >> name >> value;) {
    if (name == key) return value;
  }
  return 0;
}

struct MemoryFiles {
  const char *limit, *usage, *files_key;
};
constexpr MemoryFiles kMemoryV2{"/memory.max", "/memory.current", "inactive_file"};
// In v1 both numbers include those of the groups below, and "no limit" is a number near 2^63.
constexpr MemoryFiles kMemoryV1{"/memory.limit_in_bytes", "/memory.usage_in_bytes",
                                "total_inactive_file"};
constexpr std::uint64_t kMemoryLimitMax = std::uint64_t{1} << 62;

std::optional<CgroupMemory> memory_of(const std::string& folder, const MemoryFiles& names) {
  const auto limit = number_in<std::uint64_t>(folder + names.limit);
  if (!limit || *limit >= kMemoryLimitMax) return std::nullopt;  // also "max"
  const std::uint64_t used = number_in<std::uint64_t>(folder + names.usage).value_or(0);
  const std::uint64_t kept = used - std::min(used, stat_of(folder, names.files_key));
  return CgroupMemory{*limit, *limit - std::min(*limit, kept)};
}

// The group's path as this process sees it, from /proc/self/cgroup: lines "id:controllers:path",
// with no controllers for v2 (`controller` empty). Inside a container without a cgroup namespace
// the path is the host's and leads nowhere; the mount point itself is the container's group then.
std::string own_group(const std::string& root, const std::string& controller) {
  std::ifstream file(root + "/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const auto first = line.find(':');
    const auto second = first == line.npos ? line.npos : line.find(':', first + 1);
    if (second == line.npos || second + 1 >= line.size() || line[second + 1] != '/') continue;
    const std::string path = line.substr(second + 1);
    if (path.find("..") != path.npos) continue;  // a path of another namespace is not followed
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    if (controllers.find("," + controller + ",") != controllers.npos) return path;
  }
  return "/";
}

// Calls visit(folder) for this process's group and all above it, up to the mount point.
template <typename Visit>
void for_each_group(const std::string& root, const std::string& controller,
                    std::initializer_list<const char*> mounts, Visit visit) {
  const std::string own = own_group(root, controller);
  for (const char* mount : mounts) {
    std::string group = own;
    for (int depth = 0; depth < kGroupsDeepMax; ++depth) {
      while (!group.empty() && group.back() == '/') group.pop_back();
      visit(root + "/sys/fs/cgroup" + mount + group);
      if (group.empty()) break;
      group = group.substr(0, group.rfind('/'));
    }
  }
}

}  // namespace

double cgroup_cpu_quota(const std::string& root) {
  double least = 0;
  const auto lower_to = [&](std::optional<double> found) {
    if (found && (least == 0 || *found < least)) least = *found;
  };
  for_each_group(root, "", {"", "/unified"},
                 [&](const std::string& folder) { lower_to(quota_v2(folder)); });
  for_each_group(root, "cpu", {"/cpu", "/cpu,cpuacct", "/cpuacct,cpu"},
                 [&](const std::string& folder) { lower_to(quota_v1(folder)); });
  return least;
}

std::optional<CgroupMemory> cgroup_memory(const std::string& root) {
  std::optional<CgroupMemory> least;
  const auto lower_to = [&](const std::optional<CgroupMemory>& found) {
    if (!found) return;
    if (!least) least = found;
    least->limit_bytes = std::min(least->limit_bytes, found->limit_bytes);
    least->free_bytes = std::min(least->free_bytes, found->free_bytes);
  };
  for_each_group(root, "", {"", "/unified"},
                 [&](const std::string& folder) { lower_to(memory_of(folder, kMemoryV2)); });
  for_each_group(root, "memory", {"/memory"},
                 [&](const std::string& folder) { lower_to(memory_of(folder, kMemoryV1)); });
  return least;
}

}  // namespace tessera
