// SPDX-License-Identifier: Apache-2.0
// How far the faces of a part are apart along the edges that they share.
//
// It is measured between the curves on the patches as they leave the converter, rounding included:
// the largest of 17 places a segment, each to the nearest place of the other face's curve.
//
// Threads. Functions of one thread. Units. Lengths of the file.
#pragma once

#include <cstddef>
#include <vector>

#include "common/math/vec3.h"
#include "common/scene/patch_surface.h"
#include "master/import/cad/curve2.h"

namespace tessera::import::cad {

// A curve on a patch that belongs to an edge.
struct EdgeUse {
  int edge = 0;
  int face = 0;
  std::size_t patch = 0;    // of the surface
  std::size_t segment = 0;  // of the surface
  Curve2 curve;             // in the patch's square
};

struct EdgeGaps {
  // [edge_count] 0 for edges of one face; of others the gap, and no less than what rounding to
  // single precision moves their points by.
  std::vector<double> widths;
  std::size_t shared = 0, open = 0;
  double largest = 0;
};

EdgeGaps measure_gaps(const PatchSurface& surface, std::vector<EdgeUse>& uses,
                      std::size_t edge_count);

}  // namespace tessera::import::cad
