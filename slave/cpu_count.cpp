#include "slave/cpu_count.h"

#include <sched.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "common/base/limits.h"

namespace tessera::slave {

namespace {

std::string first_line(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

// Our own group of cgroup v2 ("0::/path"), or nothing.
std::string own_group() {
  std::ifstream in("/proc/self/cgroup");
  std::string line;
  while (std::getline(in, line)) {
    if (line.starts_with("0::/")) return line.substr(4);
  }
  return {};
}

std::optional<int> quota() {
  const std::filesystem::path root = "/sys/fs/cgroup";
  std::optional<int> least;
  const auto take = [&least](std::optional<int> cpus) {
    if (cpus) least = least ? std::min(*least, *cpus) : *cpus;
  };
  // A quota of any group above ours holds for us as well.
  std::filesystem::path group = own_group();
  while (true) {
    take(parse_cpu_max(first_line(root / group / "cpu.max")));
    if (group.empty() || group == group.parent_path()) break;
    group = group.parent_path();
  }
  // cgroup v1.
  const std::string quota_us = first_line(root / "cpu/cpu.cfs_quota_us");
  const std::string period_us = first_line(root / "cpu/cpu.cfs_period_us");
  if (!quota_us.empty() && quota_us.front() != '-') take(parse_cpu_max(quota_us + " " + period_us));
  return least;
}

}  // namespace

std::optional<int> parse_cpu_max(std::string_view text) {
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos) return std::nullopt;
  const auto number = [](std::string_view digits) -> std::optional<long long> {
    long long value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end == digits.data() || value <= 0) return std::nullopt;
    return value;
  };
  const std::optional<long long> quota_us = number(text.substr(0, space));
  const std::optional<long long> period_us = number(text.substr(space + 1));
  if (!quota_us || !period_us) return std::nullopt;
  const long long cpus = *quota_us / *period_us + (*quota_us % *period_us != 0 ? 1 : 0);
  return static_cast<int>(std::clamp<long long>(cpus, 1, kWorkersMax));
}

int usable_cpu_count() {
  int cpus = static_cast<int>(std::thread::hardware_concurrency());
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) cpus = CPU_COUNT(&set);
  if (const std::optional<int> limit = quota()) cpus = std::min(cpus, *limit);
  return std::clamp(cpus, 1, kWorkersMax);
}

}  // namespace tessera::slave
