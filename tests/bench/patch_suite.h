// SPDX-License-Identifier: Apache-2.0
// The suite "patch": rays per CPU-second through patches as they are, beside Embree's triangles of
// the same patches at several finenesses, in the same run, interleaved; each with its error.
//
// Rows. Camera rays are the same for all. Secondary rays start where the row's own camera rays have
// hit, or triangles would answer for starts that lie behind them. Of the ways to trace rays (fans,
// packets, single rays), each row has the fastest.
//
// Threads. One.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Appends JSON, one object a scene, to `json`.
Status run_patch_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
