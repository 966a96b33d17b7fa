// SPDX-License-Identifier: Apache-2.0
// How far the curve that a part of a trimming segment is on its patch goes beside its chord.
//
// C(t) = S(c(t)) has C'' = S_uu u'^2 + 2 S_uv u' v' + S_vv v'^2 + S_u u'' + S_v v'', and is within
// max |C''| / 8 of its chord, for a parameter of length 1. Derivatives of S are bounded over the
// box of the part's own control points, so that they are those of a line where a border of the
// patch is one; those of c by the differences of its control points: with A = w (c - middle),
// w c' = A' - w' (c - middle), w c'' = A'' - 2 w' c' - w'' (c - middle).
//
// Threads. Pure functions of what was given at the begin.
#pragma once

#include "slave/core/primitive/patch/patch_net.h"
#include "slave/core/primitive/patch/trim_part.h"

namespace tessera::core {

class SegmentBend {
 public:
  // Requires: a patch that was checked (patch_input.h); its numbers outlive this.
  explicit SegmentBend(const Patch& patch);

  // By parameter: of a point and that of the chord at the same share. Infinite where bounds are.
  double away_from_chord(const TrimPart& part, int degree) const;

 private:
  const Patch patch_;
  PatchPoint points_[kPatchPointsMax];
  PatchNet x_[3], w_;  // w S and w, in units of the patch's extent
};

}  // namespace tessera::core
