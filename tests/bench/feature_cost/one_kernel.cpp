// SPDX-License-Identifier: Apache-2.0
// One kernel compiled alone, without other structures, other kinds of answers or bundles.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3 | HWY_AVX3_DL)
#define HWY_BROKEN_EMU128 1
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/feature_cost/one_kernel.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/traverse/packet_call-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

#if defined(TESSERA_FEATURE_ANY)
uint64_t trace_one(const BvhView<8, TrianglesOnly<8>>& scene, const Fan& rays) {
  return occluded_fan(scene, rays);
}
#elif defined(TESSERA_FEATURE_KD)
void trace_one(const KdView<8, TrianglesOnly<8>>& scene, const Fan& rays, const HitArrays& hits) {
  closest_fan(scene, rays, hits);
}
#else
void trace_one(const BvhView<8, TrianglesOnly<8>>& scene, const Fan& rays, const HitArrays& hits) {
  closest_fan(scene, rays, hits);
}
#endif

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "tests/bench/feature_cost/kernels.h"

namespace tessera::core {

namespace {

// The kernel is called through a pointer, as those of the table are.
decltype(&N_AVX2::trace_one) volatile trace_one = N_AVX2::trace_one;

}  // namespace

uint64_t trace_once(const FeatureScene& scene, const Fan& rays,
                    [[maybe_unused]] const HitArrays& hits) {
#if defined(TESSERA_FEATURE_ANY)
  return trace_one(scene.bvh, rays);
#elif defined(TESSERA_FEATURE_KD)
  trace_one(scene.kd, rays, hits);
#else
  trace_one(scene.bvh, rays, hits);
#endif
  return 0;
}

}  // namespace tessera::core

#endif  // HWY_ONCE
