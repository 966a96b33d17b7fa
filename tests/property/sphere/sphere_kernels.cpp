// SPDX-License-Identifier: Apache-2.0
// Rays through both structures over balls, compiled once per instruction set by Highway; see slave/core/kernels.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/property/sphere/sphere_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/view_kernels-inl.h"
#include "tests/property/sphere/sphere_leaf-inl.h"

#if HWY_ONCE

#include "tests/property/sphere/sphere_kernels.h"

namespace tessera::core {
namespace {

template <template <int> class View>
ViewTables<View> tables_for(Isa isa) {
  switch (isa) {
#if HWY_TARGETS & HWY_AVX3
    case Isa::kAvx512:
      return N_AVX3::view_tables<View>();
#endif
#if HWY_TARGETS & HWY_AVX2
    case Isa::kAvx2:
      return N_AVX2::view_tables<View>();
#endif
#if HWY_TARGETS & HWY_SSE4
    case Isa::kSse4:
      return N_SSE4::view_tables<View>();
#endif
    default:
      return N_SCALAR::view_tables<View>();
  }
}

}  // namespace

ViewTables<SphereBvh> sphere_bvh_kernels(Isa isa) { return tables_for<SphereBvh>(isa); }
ViewTables<SphereKd> sphere_kd_kernels(Isa isa) { return tables_for<SphereKd>(isa); }

}  // namespace tessera::core

#endif  // HWY_ONCE
