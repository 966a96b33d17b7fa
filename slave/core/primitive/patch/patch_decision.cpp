// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/patch_decision.h"

namespace tessera::core {

PatchDecision decide(const Patch& patch, const SubPatch& part, const PatchRay& ray) {
  const int m = patch.degree_u, n = patch.degree_v;
  PatchPoint local[kPatchPointsMax];
  plain::local_points(part, patch, local);
  double origin[3] = {}, direction[3] = {};
  for (int k = 0; k < 3; ++k) {
    origin[k] = double{ray.origin[k]};
    direction[k] = double{ray.direction[k]};
  }
  const auto by = [&](auto decided) {
    return decided(part, local, m, n, patch.extent, origin, direction);
  };
  // Planes, cylinders and cones are most of the faces of CAD files.
  if (patch.is_rational) {
    if (m == 2 && n == 2) return by(plain::decided<double, true, 2, 2>);
    if (m == 2 && n == 1) return by(plain::decided<double, true, 2, 1>);
    return by(plain::decided<double, true, 0, 0>);
  }
  if (m == 3 && n == 3) return by(plain::decided<double, false, 3, 3>);
  if (m == 1 && n == 1) return by(plain::decided<double, false, 1, 1>);
  return by(plain::decided<double, false, 0, 0>);
}

}  // namespace tessera::core
