// SPDX-License-Identifier: Apache-2.0
// The acceleration structures that rays may go through, and their names.
//
// Threads. Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera::core {

// The acceleration structure that rays traverse; answers do not depend on it, only time does.
// kAuto: the fastest one for most rays, as measured (README.md). kKd: a kd-tree that is built in
// the time of the hierarchy; kKdQuality: one that takes a good two times as long to build.
// kBvhQuality: a hierarchy whose primitives are cut at planes where boxes would overlap;
// meshes that are instanced keep whole ones.
enum class Structure : std::uint8_t { kAuto, kBvh, kKd, kKdQuality, kBvhQuality };

// The names as users write them. Shape: [5], in the order of Structure.
const std::vector<std::string>& structure_names();
// Returns: kInvalidArgument for an unknown name, naming those that there are.
Result<Structure> parse_structure(const std::string& name);

}  // namespace tessera::core
