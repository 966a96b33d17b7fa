// SPDX-License-Identifier: Apache-2.0
// What the complete solver of degrees up to 3 is given and what it answers.
// Fixed-size types only and no functions.
#pragma once

#include "slave/core/primitive/patch/patch_layout.h"

namespace tessera::core {

struct SolvedPatch {
  double t, u, v;
  int box_count;  // looked at
  bool is_hit, is_exhausted;
};

// Finds the nearest root with t in [t_min, t_max]. Shape: origin, direction [3].
// Requires: degrees up to kCubicMax; finite numbers, and a direction that is not zero.
using CubicSolverCall = void (*)(const Patch& patch, const SubPatch& part, const float* origin,
                                 const float* direction, const float* t_range, SolvedPatch& to);

inline constexpr int kCubicMax = 3;
inline constexpr int kSolverBoxesMax = 1024;

}  // namespace tessera::core
