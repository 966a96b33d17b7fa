// SPDX-License-Identifier: Apache-2.0
// The suite "build": how long each structure takes to build by number of threads, beside Embree
// where it is there.
//
// Threads. Those that are measured.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Of the options, scenes, isa (width of the structures), repeats, with_all_peers. Appends JSON, one
// object a scene, to `json`.
Status run_build_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
