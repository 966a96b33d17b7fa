// SPDX-License-Identifier: Apache-2.0
// The suite "thesis": the tables of chapters 4 and 5 of the thesis, counted on the benchmark's
// scenes with the thesis's own methods, beside its figures.
//
// Threads. One; trees are built on all.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Uses the options scenes and size_px. Appends JSON, one object a scene, to `json`.
Status run_thesis_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
