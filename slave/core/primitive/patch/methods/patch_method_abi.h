// SPDX-License-Identifier: Apache-2.0
// The answer of one sub-patch to one ray by a method other than the usual one, as traversals ask
// for it: a function and its settings.
//
// Declarations only: kernel files, which are compiled once per instruction set, may include this.
// Threads. Calls are pure functions.
#pragma once

#include "slave/core/primitive/patch/patch_answer_abi.h"

namespace tessera::core {

// Returns: the nearest hit from t_min on that trims keep, as far as the method finds it. Shape:
// origin [3], direction [3]. Requires: finite numbers, and a direction that is not zero.
struct PatchMethodCall {
  PatchAnswer (*answer)(const void* how, const Patch& patch, const SubPatch& part,
                        const float* origin, const float* direction, float t_min);
  const void* how;  // the method's settings
};

}  // namespace tessera::core
