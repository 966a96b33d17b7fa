// SPDX-License-Identifier: Apache-2.0
#include "common/base/free_memory.h"

#include <algorithm>
#include <fstream>

#include "common/base/cgroup.h"

namespace tessera {

std::optional<std::uint64_t> free_memory_bytes(const std::string& root) {
  std::ifstream file(root + "/proc/meminfo");
  for (std::string key; file >> key;) {
    std::uint64_t kib = 0;
    if (key == "MemAvailable:" && file >> kib) {
      const auto group = cgroup_memory(root);
      return std::min(kib << 10, group ? group->free_bytes : kib << 10);
    }
  }
  return std::nullopt;
}

}  // namespace tessera
