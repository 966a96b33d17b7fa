// SPDX-License-Identifier: Apache-2.0
// The entry points of methods for bundles of rays.
//
// Threads. Constants.
#if defined(TESSERA_BENCH_METHOD_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_BENCH_METHOD_LANES_INL_H_
#undef TESSERA_BENCH_METHOD_LANES_INL_H_
#else
#define TESSERA_BENCH_METHOD_LANES_INL_H_
#endif

#include "tests/bench/lane_newton-inl.h"
#include "tests/bench/lane_refine-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <size_t kMost, class Leaf>
void trace_lanes(const LaneScene& scene, const LaneHow& how, LaneBundle& bundle) {
  LaneRaysIn<kMost> rays(bundle);
  Leaf leaf(scene, how, bundle, rays);
  walk(scene, rays, leaf);
  rays.write_to(bundle);
}

constexpr LaneKernels lane_kernels() {
  return {{trace_lanes<1, LaneNewton<1, LaneStart::kMiddle>>,
           trace_lanes<4, LaneNewton<4, LaneStart::kMiddle>>,
           trace_lanes<16, LaneNewton<16, LaneStart::kMiddle>>},
          {trace_lanes<1, LaneNewton<1, LaneStart::kNeighbour>>,
           trace_lanes<4, LaneNewton<4, LaneStart::kNeighbour>>,
           trace_lanes<16, LaneNewton<16, LaneStart::kNeighbour>>},
          {trace_lanes<1, LaneRefine<1>>, trace_lanes<4, LaneRefine<4>>,
           trace_lanes<16, LaneRefine<16>>},
          {trace_lanes<1, LaneNewton<1, LaneStart::kSerial>>,
           trace_lanes<4, LaneNewton<4, LaneStart::kSerial>>,
           trace_lanes<16, LaneNewton<16, LaneStart::kSerial>>},
          {static_cast<int>(kLanesOf<FloatsOf<1>>), static_cast<int>(kLanesOf<FloatsOf<4>>),
           static_cast<int>(kLanesOf<FloatsOf<16>>)}};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
