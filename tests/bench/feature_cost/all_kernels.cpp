// SPDX-License-Identifier: Apache-2.0
// Traces with a kernel of the table that slaves use, so that all other kernels are linked in, too.
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/ray/fan_of.h"
#include "tests/bench/feature_cost/kernels.h"

namespace tessera::core {

namespace {

const KernelTable& kernels = kernels_for(Isa::kAvx2);

}  // namespace

uint64_t trace_once(const FeatureScene& scene, const FanPacket& rays,
                    [[maybe_unused]] PacketHits& hits) {
#if defined(TESSERA_FEATURE_ANY)
  return kernels.bvh8.occluded_fan(scene.bvh, fan_of(rays));
#elif defined(TESSERA_FEATURE_KD)
  kernels.kd8.closest_fan(scene.kd, fan_of(rays), arrays_of(hits));
#else
  kernels.bvh8.closest_fan(scene.bvh, fan_of(rays), arrays_of(hits));
#endif
  return 0;
}

}  // namespace tessera::core
