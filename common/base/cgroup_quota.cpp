#include "common/base/cgroup_quota.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

namespace tessera {
namespace {

constexpr int kGroupsDeepMax = 64;
constexpr double kQuotaMax = 1e6;  // of a file that says infinity

std::optional<double> number_of(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// v2: "max 100000" or "150000 100000".
std::optional<double> quota_v2(const std::string& folder) {
  std::ifstream file(folder + "/cpu.max");
  std::string quota, period;
  if (!(file >> quota >> period)) return std::nullopt;
  const auto q = number_of(quota), p = number_of(period);
  if (!q || !p || !(*q > 0) || !(*p > 0)) return std::nullopt;  // "max", NaN
  return std::min(*q / *p, kQuotaMax);
}

// v1: -1 where there is none.
std::optional<double> quota_v1(const std::string& folder) {
  std::ifstream quota_file(folder + "/cpu.cfs_quota_us");
  std::ifstream period_file(folder + "/cpu.cfs_period_us");
  double quota = 0, period = 0;
  if (!(quota_file >> quota) || !(period_file >> period) || quota <= 0 || period <= 0)
    return std::nullopt;
  return quota / period;
}

// A group's path as this process sees it, from /proc/self/cgroup: lines "id:controllers:path", with
// no controllers for v2. Inside a container without a cgroup namespace the path is the host's and
// leads nowhere; the mount point itself is the container's group then.
struct Groups {
  std::string v2 = "/", v1 = "/";
};

Groups own_groups(const std::string& root) {
  Groups groups;
  std::ifstream file(root + "/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {
    const auto first = line.find(':');
    const auto second = first == line.npos ? line.npos : line.find(':', first + 1);
    if (second == line.npos || second + 1 >= line.size() || line[second + 1] != '/') continue;
    const std::string path = line.substr(second + 1);
    std::stringstream controllers(line.substr(first + 1, second - first - 1));
    if (controllers.str().empty()) groups.v2 = path;
    for (std::string name; std::getline(controllers, name, ',');) {
      if (name == "cpu") groups.v1 = path;
    }
  }
  return groups;
}

// The least limit of `group` and all above it, below `mount`.
template <typename Quota>
void lower_by(double& least, const std::string& mount, std::string group, Quota quota) {
  if (group.find("..") != group.npos) group = "/";  // of another namespace: not to be followed
  for (int depth = 0; depth < kGroupsDeepMax; ++depth) {
    while (!group.empty() && group.back() == '/') group.pop_back();
    if (const auto found = quota(mount + group); found && (least == 0 || *found < least))
      least = *found;
    if (group.empty()) return;
    group = group.substr(0, group.rfind('/'));
  }
}

}  // namespace

double cgroup_cpu_quota(const std::string& root) {
  const Groups groups = own_groups(root);
  double least = 0;
  const std::string base = root + "/sys/fs/cgroup";
  for (const char* mount : {"", "/unified"}) lower_by(least, base + mount, groups.v2, quota_v2);
  for (const char* mount : {"/cpu", "/cpu,cpuacct", "/cpuacct,cpu"})
    lower_by(least, base + mount, groups.v1, quota_v1);
  return least;
}

}  // namespace tessera
