// SPDX-License-Identifier: Apache-2.0
// The suite "patch": rays per CPU-second of freeform patches that are hit where they are, beside
// Embree's triangles at N x N cells a patch, on the same rays in the same run, interleaved; with
// the error of each, the rays that it loses, memory, and what building it took.
//
// Threads. One.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Appends one JSON object for each scene: "teapot" (32 patches) and "teapots" (4,096 of them, in a
// cube; quick: 512).
Status run_patch_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
