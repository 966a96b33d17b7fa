// SPDX-License-Identifier: Apache-2.0
#include "slave/core/accel/structure.h"

#include <algorithm>

namespace tessera::core {

const std::vector<std::string>& structure_names() {
  static const std::vector<std::string> names{"auto", "bvh", "kd", "kd-quality", "bvh-quality"};
  return names;
}

Result<Structure> parse_structure(const std::string& name) {
  const auto& names = structure_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<Structure>(found - names.begin());
  std::string known;
  for (const std::string& other : names) known += (known.empty() ? "" : ", ") + other;
  return Status::invalid_argument("structure " + name + ": there are " + known);
}

}  // namespace tessera::core
