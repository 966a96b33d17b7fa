// SPDX-License-Identifier: Apache-2.0
// The suite "moves": CPU time to prepare a version of a scene in which one instance of many stands
// elsewhere, when the version before is there. What does not move is not built again, so the time
// follows the number of instances and not what their meshes hold. Beside it: how much slower rays
// are in a hierarchy that was edited for thousands of moves than in one that was built anew.
//
// Threads. One.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Appends JSON, one object a scene, to `json`. The scenes are the suite's own.
Status run_move_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
