// SPDX-License-Identifier: Apache-2.0
// Methods for bundles of rays, by instruction set.
// Threads. Pure function.
#pragma once

#include "common/base/isa.h"
#include "tests/bench/method_lanes_layout.h"

namespace tessera::core {

// Requires: the CPU has the set.
bench::LaneKernels lane_kernels(Isa isa);

}  // namespace tessera::core
