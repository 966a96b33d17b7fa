// SPDX-License-Identifier: Apache-2.0
// Splits patches into sub-patches, until the frame of each leaves open at most a given part of its
// square for rays up to a given angle to its normal; with boxes for the builders of structures.
//
// A ray of slope (p, q) in the frame meets the sub-patch within reach_a + |p| reach_n of where it
// passes the plane n = 0, by x, or not at all, and so by y. That radius is what is asked for: it
// makes decisions short. It is no part of what makes them right, which each ray's own bounds do
// (patch_decision-inl.h), so no setting loses a ray.
//
// Threads. Pure function.
#pragma once

#include <cstdint>
#include <vector>

#include "common/math/bounds3.h"
#include "slave/core/primitive/patch/fat_border_spans.h"
#include "slave/core/primitive/patch/patch_layout.h"
#include "slave/core/primitive/patch/trim_grid.h"

namespace tessera::core {

struct PatchSplitting {
  double radius = 0.5;  // of the half of the square
  double slope = 3;     // tangent of the angle to the normal
  // Halvings in each direction, at most kSubPatchLevelMax: a patch has up to 4^level_max parts.
  int level_max = 5;
  double smallest = 0x1p-5;  // no part is split whose box is smaller than this part of its patch's
  // Halvings in each direction of parts of which trims keep some and leave out some, where shape
  // alone asks for fewer: the less of a part is left out, the fewer rays are decided for nothing.
  int trim_level_max = 0;
  FatSplitting borders = {};
  TrimCellOptions cells = {};
};

struct SubPatches {
  std::vector<SubPatch> parts;
  std::vector<Bounds3f> boxes;  // as many; each holds its part of the surface
};

// Appends the parts of a patch. They tile it: ranges meet and do not overlap.
// Requires: a patch that was checked (patch_input.h).
void split_patch(const Patch& patch, std::uint32_t number, const PatchSplitting& splitting,
                 SubPatches& to);

// The same of what is kept: parts that trims leave out are not there, and those that they cut are
// marked. Requires: patch.trims.
void split_trimmed_patch(const Patch& patch, std::uint32_t number, const PatchSplitting& splitting,
                         SubPatches& to);

}  // namespace tessera::core
