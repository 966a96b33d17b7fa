// SPDX-License-Identifier: Apache-2.0
// Rays and decisions side by side, as registers of doubles take them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

inline constexpr int kPatchLanes = 16;

struct alignas(64) PatchLaneRays {
  double origin[3][kPatchLanes], direction[3][kPatchLanes];
};

// Bit i of a mask: ray i.
struct alignas(64) PatchLaneAnswers {
  double t[kPatchLanes], u[kPatchLanes], v[kPatchLanes];
  uint32_t is_hit, is_undecided;
};

using DecidePatchLanes = void (*)(const Patch& patch, const SubPatch& part,
                                  const PatchLaneRays& rays, PatchLaneAnswers& answers);

}  // namespace tessera::core
