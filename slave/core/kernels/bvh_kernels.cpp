// SPDX-License-Identifier: Apache-2.0
// Rays through a hierarchy over triangles, compiled once per instruction set by Highway; see
// kernels.cpp.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/bvh_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/view_kernels-inl.h"
#include "slave/core/traverse/few_primitives-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::core {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_AVX3
// Rays through a few triangles go through all of them.
template <>
constexpr ViewKernels<TriangleBvh<16>> kKernels<TriangleBvh<16>>{
    closest_ray<TriangleBvh<16>>,
    occluded_ray<TriangleBvh<16>>,
    enter_fans<TriangleBvh<16>>,
    closest_fan<TriangleBvh<16>>,
    occluded_fan<TriangleBvh<16>>,
    occluded_fans<TriangleBvh<16>>,
    closest_of_few_or_many<TriangleBvh<16>>,
    occluded_by_few_or_many<TriangleBvh<16>>};
#endif
}  // namespace HWY_NAMESPACE
}  // namespace tessera::core
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "slave/core/kernels/view_tables.h"

namespace tessera::core {

ViewTables<TriangleBvh> bvh_kernels(Isa isa) { TESSERA_RETURN_OF(isa, view_tables<TriangleBvh>()) }

}  // namespace tessera::core

#endif  // HWY_ONCE
