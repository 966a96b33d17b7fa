// SPDX-License-Identifier: Apache-2.0
// The suite "build": how long each structure takes to build by number of threads, beside Embree
// where it is there.
//
// Threads. The caller's, and those whose work is measured.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Uses the options scenes, isa (width of the structures), repeats, with_all_peers and with_sizes.
// Appends JSON, one object a scene, to `json`.
Status run_build_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
