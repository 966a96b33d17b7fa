// SPDX-License-Identifier: Apache-2.0
// The answer of one sub-patch to one ray. It belongs to the two and to no method, bundle or
// instruction set: one sequence of double operations, of which nothing is fused.
//
// Of several sub-patches the nearest t wins, then the lowest number; sub-patches that share a
// border may both meet a ray there, and at least one does. Where a line is tangent within the
// roundings of float32, either answer is right.
//
// Threads. Pure functions, but for the solver's memory, which is one thread's.
#pragma once

#include "slave/core/primitive/patch/complete_solver.h"
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/primitive/patch/patch_ray.h"

namespace tessera::core {

// How the answer was found.
enum class PatchWay { kDecision, kCompleteSolver };

// Returns: the nearest hit within t_min and t_max. Rays with NaN, infinities or a zero direction
// miss.
PatchHit patch_hit(const Patch& patch, const SubPatch& part, const PatchRay& ray,
                   CompleteSolver& solver, PatchWay* way = nullptr);

}  // namespace tessera::core
