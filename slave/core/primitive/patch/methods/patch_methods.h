// SPDX-License-Identifier: Apache-2.0
// The methods for patches that a frame may ask for, by name.
// Threads. Pure functions.
#pragma once

#include "common/frame/patch_method.h"
#include "slave/core/primitive/patch/methods/patch_method_abi.h"

namespace tessera::core {

// Returns: null for the usual way, which has code of its own.
const PatchMethodCall* patch_method_call(PatchMethod method);

// The answer by any of them. Requires: as PatchMethodCall.
PatchAnswer answer_by(PatchMethod method, const Patch& patch, const SubPatch& part,
                      const float* origin, const float* direction, float t_min);

// How far from the surface hits of the patch may be, beyond roundings, in the scene's units.
double method_error(PatchMethod method, const Patch& patch);

}  // namespace tessera::core
