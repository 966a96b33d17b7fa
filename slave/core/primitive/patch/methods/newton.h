// SPDX-License-Identifier: Apache-2.0
// Newton's iteration from the middle of a sub-patch, without proof (W. Martin, E. Cohen, R. Fish,
// P. Shirley, "Practical ray tracing of trimmed NURBS surfaces", Journal of Graphics Tools 5, 2000;
// thesis, 6.4): it ends at a root where the point is near enough to the ray, and gives up where a
// step leads farther away from it.
//
// Weakness: it loses roots that it does not run into: at silhouettes and folds, of which it finds
// one root of two at most, where dS/du and dS/dv are along each other, and where a part is not flat
// enough; and it may run into the neighbour's root.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/primitive/patch/methods/patch_method_abi.h"

namespace tessera::core {

class NearestRoot;
struct RaySight;

struct NewtonHow {
  int steps_max = 12;  // of the thesis's "predefined threshold"
};

// Returns: how many steps were taken.
int newton_roots(const NewtonHow& how, const Patch& patch, const SubPatch& part,
                 const RaySight& sight, NearestRoot& to);

}  // namespace tessera::core
