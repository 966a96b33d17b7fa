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
  if (!patch.is_rational)
    return m == 3 && n == 3 ? by(plain::decided<double, false, 3, 3>)
                            : by(plain::decided<double, false, 0, 0>);
  return m == 2 && n == 2 ? by(plain::decided<double, true, 2, 2>)
                          : by(plain::decided<double, true, 0, 0>);
}

}  // namespace tessera::core
