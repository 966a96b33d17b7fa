// SPDX-License-Identifier: Apache-2.0
// Methods for bundles of rays, compiled once per instruction set by Highway; see
// slave/core/kernels.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/method_lanes.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "tests/bench/method_lanes-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "tests/bench/method_lanes.h"

namespace tessera::core {

bench::LaneKernels lane_kernels(Isa isa) { TESSERA_RETURN_OF(isa, lane_kernels()) }

}  // namespace tessera::core

#endif  // HWY_ONCE
