// SPDX-License-Identifier: Apache-2.0
// Points and derivatives of a patch, for plain numbers: the text of bernstein-inl.h.
// Derivatives are of the patch's own parameters. Nothing is fused, so the bits are the same
// everywhere; errors are as bernstein-inl.h counts them.
// Threads. Pure functions.
#pragma once

#define TESSERA_PLAIN_TEXT

#include "slave/core/primitive/patch/bernstein-inl.h"

namespace tessera::core {

using PatchJet = plain::PatchJet<double>;

struct PatchCurvature {
  double duu[3], duv[3], dvv[3];
};

// Degrees that are frequent have their own code, with the same operations.
PatchJet evaluate(const Patch& patch, double u, double v);
// The same of points that are not the patch's own, of its degrees.
PatchJet evaluate(const Patch& patch, const PatchPoint* points, double u, double v);
// Shape: points [kPatchPointsMax], of which the first become those of the patch.
void take_points(const Patch& patch, PatchPoint* points);

// Second derivatives. They are for bounds and curvature, and no decision asks for them.
PatchCurvature second_derivatives(const Patch& patch, double u, double v);

}  // namespace tessera::core
