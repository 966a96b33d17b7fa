// SPDX-License-Identifier: Apache-2.0
// Borders that lie beside each other: both faces of an edge have its curve, nearly to the bit, so
// one sub-patch stands in the hierarchy for those that its own bounds hold, or nearly hold. What a
// ray meets is asked of each of them, as if it were there itself; packets look at one instead of
// two, and the hierarchy has half as many boxes.
//
// Threads. Pure function.
#pragma once

#include <span>

#include "common/math/bounds3.h"
#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

// Links borders to one that holds them (next_border_beside()), whose bounds and box grow, and
// leaves their own boxes empty. Other sub-patches stay as they are.
// Requires: all patches have their numbers. Shape: parts, boxes [count], of one instance.
void join_borders_beside(const Patch* patches, std::span<SubPatch> parts,
                         std::span<Bounds3f> boxes);

}  // namespace tessera::core
