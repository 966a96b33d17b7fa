// SPDX-License-Identifier: Apache-2.0
// Single rays through a hierarchy over triangles and sub-patches that a method of the frame's
// answers for, compiled once per instruction set by Highway; see kernels.cpp.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/method_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/method_kernels_layout.h"
#include "slave/core/primitive/freeform/method_leaf-inl.h"
#include "slave/core/primitive/placed/method_place_leaf-inl.h"
#include "slave/core/traverse/bvh_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <class View, bool kAny>
using MethodRayTracer =
    BvhRayTracer<View, typename LeafTests<typename View::Shapes>::template Ray<kAny>>;

template <class View>
void closest_by_method(const View& scene, const SingleRay& ray, SingleHit& hit) {
  MethodRayTracer<View, false> tracer(scene);
  hit = {0, kNoPrimitive};
  if (tracer.run(ray)) hit = {tracer.ray().best_t, static_cast<uint32_t>(tracer.ray().best)};
}

template <class View>
bool occluded_by_method(const View& scene, const SingleRay& ray) {
  return MethodRayTracer<View, true>(scene).run(ray);
}

template <class View>
constexpr MethodKernels<View> kByMethod{closest_by_method<View>, occluded_by_method<View>};

constexpr MethodTables method_tables() {
  return {kByMethod<MethodView<8>>, kByMethod<MethodView<16>>, kByMethod<MethodPlacesView<8>>,
          kByMethod<MethodPlacesView<16>>};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "slave/core/kernels/method_kernels.h"

namespace tessera::core {

MethodTables method_kernels(Isa isa) { TESSERA_RETURN_OF(isa, method_tables()) }

}  // namespace tessera::core

#endif  // HWY_ONCE
