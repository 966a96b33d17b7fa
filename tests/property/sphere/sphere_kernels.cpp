// SPDX-License-Identifier: Apache-2.0
// Rays through both structures over balls, compiled once per instruction set by Highway; see
// slave/core/kernels.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/property/sphere/sphere_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/view_kernels-inl.h"
#include "tests/property/sphere/sphere_leaf-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "tests/property/sphere/sphere_kernels.h"

namespace tessera::core {
namespace {

template <template <int> class View>
ViewTables<View> tables_for(Isa isa) {
  TESSERA_RETURN_OF(isa, view_tables<View>())
}

}  // namespace

ViewTables<SphereBvh> sphere_bvh_kernels(Isa isa) { return tables_for<SphereBvh>(isa); }
ViewTables<SphereKd> sphere_kd_kernels(Isa isa) { return tables_for<SphereKd>(isa); }

}  // namespace tessera::core

#endif  // HWY_ONCE
