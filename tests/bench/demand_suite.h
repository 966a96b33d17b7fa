// SPDX-License-Identifier: Apache-2.0
// The suite "demand": what the first frame of a scene costs, much of which is hidden, where all of
// it is built beforehand and where meshes are built when the first ray reaches them.
//
// Threads. One.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Appends JSON, one object a way to build, to `json`. Its scene is "building", split into objects.
Status run_demand_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
