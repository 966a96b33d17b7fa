// SPDX-License-Identifier: Apache-2.0
// Areas and volumes of trimmed patches by Gauss quadrature in double, for tests.
//
// What loops enclose is measured around them (Green): the sum over segments of F dv, where F(u, v)
// is the integral of |dS/du x dS/dv| from 0 to u. Loops within loops count with the other sign.
#pragma once

#include <vector>

#include "common/scene/patch_surface.h"

namespace tessera::test {

// [patch_count] areas of what is kept, in square scene units.
std::vector<double> patch_areas(const PatchSurface& surface);

// What a closed surface encloses, in cubic scene units: positive where its normals point out.
double surface_volume(const PatchSurface& surface);

}  // namespace tessera::test
