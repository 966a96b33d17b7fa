// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <memory>

#include "slave/core/primitive/patch/patch_answer_abi.h"
#include "slave/core/primitive/patch/patch_hit.h"

namespace tessera::core {

PatchAnswer patch_answer(const Patch& patch, const SubPatch& part, const float* origin,
                         const float* direction, float t_min) {
  thread_local const auto solver = std::make_unique<CompleteSolver>();
  const PatchRay ray{{origin[0], origin[1], origin[2]},
                     {direction[0], direction[1], direction[2]},
                     t_min,
                     std::numeric_limits<float>::infinity()};
  const PatchHit hit = patch_hit(patch, part, ray, *solver);
  return {hit.is_hit, static_cast<float>(hit.t), hit.u, hit.v};
}

}  // namespace tessera::core
