// SPDX-License-Identifier: Apache-2.0
#include "slave/core/primitive/patch/patch_hit.h"

#include <cmath>

#include "slave/core/primitive/patch/patch_decision.h"

namespace tessera::core {
namespace {

bool is_ray(const PatchRay& ray) {
  bool is_finite = true, moves = false;
  for (int a = 0; a < 3; ++a) {
    is_finite = is_finite && std::isfinite(ray.origin[a]) && std::isfinite(ray.direction[a]);
    moves = moves || ray.direction[a] != 0;
  }
  return is_finite && moves;
}

}  // namespace

PatchHit patch_hit(const Patch& patch, const SubPatch& part, const PatchRay& ray,
                   CompleteSolver& solver, PatchWay* way) {
  if (way != nullptr) *way = PatchWay::kDecision;
  if (!is_ray(ray)) return {};
  if (part.has_frame && !plain::is_left_to_solver(patch, part)) {
    const PatchDecision decision = decide(patch, part, ray);
    if (!decision.is_undecided) {
      const bool is_hit =
          decision.is_hit && decision.t >= double{ray.t_min} && decision.t <= double{ray.t_max};
      return is_hit ? PatchHit{true, decision.t, decision.u, decision.v} : PatchHit{};
    }
  }
  if (way != nullptr) *way = PatchWay::kCompleteSolver;
  return solver.solve(patch, part, ray);
}

}  // namespace tessera::core
