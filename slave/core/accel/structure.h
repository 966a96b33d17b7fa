// SPDX-License-Identifier: Apache-2.0
// The names of the structures that rays may go through.
//
// Threads. Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"

namespace tessera::core {

// What rays go through; answers do not depend on it, only time does. kAuto: what is fastest for
// most rays, as measured (README.md). kKd: built in the time of the hierarchy; kKdQuality: in a
// good two times of it.
enum class Structure : std::uint8_t { kAuto, kBvh, kKd, kKdQuality };

// As users write them. Shape: [4], as in Structure.
const std::vector<std::string>& structure_names();
// Returns: kInvalidArgument, naming what there is.
Result<Structure> parse_structure(const std::string& name);

}  // namespace tessera::core
