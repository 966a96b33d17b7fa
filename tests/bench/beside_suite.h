// SPDX-License-Identifier: Apache-2.0
// The suite "beside": what rendering loses to builds that run beside it, with the render threads
// and the builder of a slave, and how long a build takes beside them, alone, and where rendering
// ends in the middle of it.
//
// Threads. One calls; as many render and build as the machine has.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Appends JSON, one object a scene, to `json`. Its scenes are its own.
Status run_beside_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
