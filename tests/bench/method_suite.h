// SPDX-License-Identifier: Apache-2.0
// The table of the methods for patches (thesis, tables 6.1 to 6.12 and figure 6.22): the same
// camera rays at the teapot through each of them and its variants, in rays per CPU-second, each
// beside its error and the rays that it loses.
//
// Rows with a hierarchy of the product trace single rays in double; rows of bundles trace 1, 4 and
// 16 rays of one eye in float32 through a plain binary hierarchy, which is the same for all of
// them.
//
// Threads. One.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/core_suite.h"

namespace tessera::bench {

// Appends JSON, one object, to `json`. Uses the options isa, is_quick, size_px, repeats and only.
Status run_method_suite(const CoreSuiteOptions& options, std::vector<std::string>& json);

}  // namespace tessera::bench
