// SPDX-License-Identifier: Apache-2.0
// The suite "trims": what it costs to ask whether a point of a patch is kept, by the number of its
// trimming loops: the product's cells, a tree of boxes (trim_tree.h), and all pieces one after the
// other; in nanoseconds, and in pieces and points of them that were looked at. Loops lie beside
// each other, one in the other, or are tall and thin; points are anywhere.
//
// Threads. One.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Appends JSON, one object a layout and number of loops, to `json`. Uses the option repeats.
Status run_trim_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
