// SPDX-License-Identifier: Apache-2.0
// The usual decision, for plain numbers: the text of patch_decision-inl.h.
// Threads. Pure functions.
#pragma once

#define TESSERA_PLAIN_TEXT

#include "slave/core/primitive/patch/patch_decision-inl.h"
#include "slave/core/primitive/patch/patch_evaluation.h"
#include "slave/core/primitive/patch/patch_ray.h"

namespace tessera::core {

using PatchDecision = plain::PatchDecision<double>;

// Requires: the sub-patch has a frame. t_min and t_max are not looked at.
PatchDecision decide(const Patch& patch, const SubPatch& part, const PatchRay& ray);

}  // namespace tessera::core
