// SPDX-License-Identifier: Apache-2.0
// Bezier clipping (T. Nishita, T. Sederberg, M. Kakimoto, "Ray tracing trimmed rational surface
// patches", SIGGRAPH 1990; thesis, 6.6): what a line through the ray and the convex hull of the
// net's distances from it rule out is cut away, by u and by v in turns, until what is left is a
// root.
//
// Repairs. Where a line cannot be had or is nearly along the other one, the distance along both is
// taken, too (A. Efremov, V. Havran, H.-P. Seidel, "Robust and numerically stable
// Bezier clipping method for ray tracing NURBS surfaces", SCCG 2005). Hulls are widened by what
// roundings may have moved them by, so that none clips a root away (by more, boxes cluster in
// tangents); a side that is as short as can be is left
// alone, and only a net that is near to the ray is a root (S. Campagna, P. Slusallek, H.-P. Seidel,
// "Ray tracing of spline surfaces: Bezier clipping, Chebyshev boxing, and bounding volume hierarchy
// - a critical comparison with new results", The Visual Computer 13, 1997). Roots that are found
// twice are one, since only the nearest is kept.
//
// Weakness: rays in tangents cluster boxes around the root, and what kMethodBoxesMax boxes have not
// found is lost.
//
// Threads. Pure functions.
#pragma once

#include "slave/core/primitive/patch/methods/patch_method_abi.h"

namespace tessera::core {

class NearestRoot;
struct RaySight;

struct ClipHow {
  double halves_above = 0.8;  // of a side that is left: both halves are looked at
  double widening = 1;        // of hulls, by so many times the noise; 0: as published first
  double line_sine = 0.25;    // of two lines, below which both distances are looked at; 0: never
};

// Returns: how many boxes were looked at.
int clip_roots(const ClipHow& how, const Patch& patch, const SubPatch& part, const RaySight& sight,
               NearestRoot& to);

}  // namespace tessera::core
