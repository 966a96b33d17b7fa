// SPDX-License-Identifier: Apache-2.0
// The usual decision of patches for 16 rays in registers, by instruction set.
// Threads. Pure function.
#pragma once

#include "common/base/isa.h"
#include "tests/property/patch/patch_lanes_layout.h"

namespace tessera::core {

// Requires: the CPU has the set.
DecidePatchLanes decide_patch_lanes(Isa isa);

}  // namespace tessera::core
