// SPDX-License-Identifier: Apache-2.0
// The suite "accuracy": how wrong answers are on the classes of hard cases, beside how fast they
// come.
//
// Threads. The caller's, and those whose work is measured.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Uses the options isa and is_quick. Appends JSON, one object a class, to `json`. Returns:
// kInternal when an answer is missed, wrong, false, leaking or invalid.
Status run_accuracy_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
