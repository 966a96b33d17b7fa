// SPDX-License-Identifier: Apache-2.0
// A part of a segment of a trimming loop, by its own control points.
// Threads. Plain values; pure functions.
#pragma once

#include "slave/core/primitive/patch/trim_curve.h"

namespace tessera::core {

struct TrimPart {
  TrimParameter from{1, 0}, to{0, 1};
  int depth = 0;                            // of halvings
  TrimCoefficient net[kTrimDegreeMax + 1];  // w u, w v, w of its control points
};

// De Casteljau's scheme at the middle. `part` becomes its second half. Returns: the first half.
TrimPart first_half(TrimPart& part, int degree);

}  // namespace tessera::core
