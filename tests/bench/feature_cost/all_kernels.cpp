// SPDX-License-Identifier: Apache-2.0
// Traces with a kernel of the table that slaves use, so that all other kernels are linked in, too.
#include "slave/core/kernels/kernel_table.h"
#include "tests/bench/feature_cost/kernels.h"

namespace tessera::core {

namespace {

const KernelTable& kernels = kernels_for(Isa::kAvx2);

}  // namespace

uint64_t trace_once(const FeatureScene& scene, const Fan& rays,
                    [[maybe_unused]] const HitArrays& hits) {
#if defined(TESSERA_FEATURE_ANY)
  return kernels.bvh8.occluded_fan(scene.bvh, rays);
#elif defined(TESSERA_FEATURE_KD)
  kernels.kd8.closest_fan(scene.kd, rays, hits);
#else
  kernels.bvh8.closest_fan(scene.bvh, rays, hits);
#endif
  return 0;
}

}  // namespace tessera::core
