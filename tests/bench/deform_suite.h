// SPDX-License-Identifier: Apache-2.0
// The suite "deforming": what a frame's structure costs where corners move and triangles stay, or
// where everything changes, beside Embree's builds for that; and rays through what was fitted and
// through what was built fast, to rays through what was built as usual.
//
// Threads. One.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Appends JSON, one object a scene, to `json`. Its scenes are its own.
Status run_deform_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
