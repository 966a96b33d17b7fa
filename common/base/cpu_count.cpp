// SPDX-License-Identifier: Apache-2.0
#include "common/base/cpu_count.h"

#include <sched.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>
#include <string>

#include "common/base/cgroup.h"
#include "common/base/limits.h"

namespace tessera {
namespace {

std::optional<int> number_of(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_number = error == std::errc() && end == text.data() + text.size() &&
                         !text.starts_with('-') && value < CPU_SETSIZE;
  return is_number ? std::optional(value) : std::nullopt;
}

}  // namespace

std::vector<int> allowed_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cpus;
  if (sched_getaffinity(0, sizeof(set), &set) != 0) return cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &set)) cpus.push_back(cpu);
  }
  return cpus;
}

int cpu_count_of(int in_mask, double quota) {
  int count = in_mask;
  // Compared as double: a quota may be more than an int holds.
  if (quota > 0 && std::ceil(quota) < count) count = static_cast<int>(std::ceil(quota));
  return std::clamp(count, 1, kWorkersMax);
}

int available_cpu_count() {
  return cpu_count_of(static_cast<int>(allowed_cpus().size()), cgroup_cpu_quota());
}

Result<std::vector<int>> parse_cpus(std::string_view text, const std::vector<int>& allowed) {
  const auto wrong = [&](const std::string& why) {
    return Status::invalid_argument(std::string(text) + ": " + why);
  };
  const std::string usage = "give how many, such as 4, or which, such as 0-3,8";
  if (const auto count = number_of(text)) {
    if (*count < 1 || static_cast<std::size_t>(*count) > allowed.size()) {
      return wrong("this process may use " + std::to_string(allowed.size()) + " processors");
    }
    return std::vector<int>(allowed.begin(), allowed.begin() + *count);
  }
  std::set<int> cpus;
  for (std::string_view rest = text; !rest.empty();) {
    const auto comma = std::min(rest.find(','), rest.size());
    const std::string_view range = rest.substr(0, comma);
    rest = rest.substr(std::min(comma + 1, rest.size()));
    const auto dash = range.find('-');
    const auto first = number_of(range.substr(0, dash));
    const auto last = dash == range.npos ? first : number_of(range.substr(dash + 1));
    if (!first || !last || *last < *first) return wrong(usage);
    for (int cpu = *first; cpu <= *last; ++cpu) {
      if (!std::binary_search(allowed.begin(), allowed.end(), cpu)) {
        return wrong("this process may not run on processor " + std::to_string(cpu));
      }
      cpus.insert(cpu);
    }
  }
  if (cpus.empty()) return wrong(usage);
  return std::vector<int>(cpus.begin(), cpus.end());
}

Status limit_cpus(const std::vector<int>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) CPU_SET(cpu, &set);
  if (sched_setaffinity(0, sizeof(set), &set) == 0) return Status::ok();
  return Status::unavailable(std::string("cannot keep to the given processors: ") +
                             std::strerror(errno));
}

}  // namespace tessera
