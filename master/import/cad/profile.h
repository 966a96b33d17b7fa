// SPDX-License-Identifier: Apache-2.0
// A curve in space as rational Bezier pieces, each with the interval of the parameter that it
// covers. Units. Lengths of the file. Threads. Plain values.
#pragma once

#include <Geom_Curve.hxx>
#include <vector>

#include "common/base/status.h"
#include "master/import/cad/axis.h"

namespace tessera::import::cad {

struct Profile {
  Axis axis;
  std::vector<std::vector<Control3>> pieces;  // [axis.cell_count()]
  double approximation = 0;
};

// The borders of angles over [from, to]: equal parts of a quarter turn at most.
std::vector<double> angle_borders(double from, double to);

// Conics, lines and B-splines are exact; other curves are approximated within 1e-7 of their size.
Result<Profile> make_profile(const Handle(Geom_Curve) & curve, double from, double to);

}  // namespace tessera::import::cad
