// SPDX-License-Identifier: Apache-2.0
// The decision of patches, compiled once per instruction set by Highway; see slave/core/kernels.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/property/patch/patch_lanes.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "tests/property/patch/patch_lanes-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "tests/property/patch/patch_lanes.h"

namespace tessera::core {

DecidePatchLanes decide_patch_lanes(Isa isa) { TESSERA_RETURN_OF(isa, decide_patch_lanes) }

}  // namespace tessera::core

#endif  // HWY_ONCE
