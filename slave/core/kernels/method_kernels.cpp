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
#include "slave/core/traverse/bvh_ray-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {

template <int W, bool kAny>
using MethodRayTracer =
    BvhRayTracer<MethodView<W>, typename LeafTests<PatchesByMethod<W>>::template Ray<kAny>>;

template <int W>
void closest_by_method(const MethodView<W>& scene, const SingleRay& ray, SingleHit& hit) {
  MethodRayTracer<W, false> tracer(scene);
  hit = {0, kNoPrimitive};
  if (tracer.run(ray)) hit = {tracer.ray().best_t, static_cast<uint32_t>(tracer.ray().best)};
}

template <int W>
bool occluded_by_method(const MethodView<W>& scene, const SingleRay& ray) {
  return MethodRayTracer<W, true>(scene).run(ray);
}

constexpr MethodTables method_tables() {
  return {{closest_by_method<8>, occluded_by_method<8>},
          {closest_by_method<16>, occluded_by_method<16>}};
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
