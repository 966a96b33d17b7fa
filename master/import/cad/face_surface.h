// SPDX-License-Identifier: Apache-2.0
// The surface of a face as a grid of rational Bezier patches, exact for planes, cylinders, cones,
// spheres, tori, extrusions and revolutions of curves that are conics or B-splines, and B-splines.
//
// A patch keeps the face's own parameters, scaled to [0, 1]^2; where the face counts angles, the
// patch counts t with tan((angle - middle) / 2) = (2 t - 1) tan(width / 4).
//
// Units. Lengths of the file. Threads. Plain values. Errors: one line, without the file.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "master/import/cad/axis.h"

class TopoDS_Face;

namespace tessera::import::cad {

struct BezierPatch {
  int degree_u = 1, degree_v = 1;
  bool is_rational = false;
  std::vector<Control3> points;  // point (i, j) is number (degree_v + 1) i + j

  // The place at (u, v), which may be outside of the square; of weight 1.
  Control3 at(double u, double v) const;
};

struct FaceSurface {
  Axis u, v;
  std::vector<BezierPatch> patches;  // cell (i, j) is number v.cell_count() i + j
  std::string kind;                  // "plane", "B-spline", ...
  double approximation = 0;          // how far the patches are off, where they are not exact
};

// Requires: bounds of the face's curves in parameters {u low, u high, v low, v high}, of extent.
// Returns: an error where the surface has no patches of degree 15 at most.
Result<FaceSurface> face_surface(const TopoDS_Face& face, const std::array<double, 4>& bounds);

}  // namespace tessera::import::cad
