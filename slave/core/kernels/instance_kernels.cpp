// SPDX-License-Identifier: Apache-2.0
// Rays through a hierarchy over instances and triangles, compiled once per instruction set by Highway; see kernels.cpp.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/instance_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/view_kernels-inl.h"
#include "slave/core/primitive/instance/instance_leaf-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/view_tables.h"

namespace tessera::core {

ViewTables<InstancedView> instance_kernels(Isa isa) {
  switch (isa) {
#if HWY_TARGETS & HWY_AVX3
    case Isa::kAvx512:
      return N_AVX3::view_tables<InstancedView>();
#endif
#if HWY_TARGETS & HWY_AVX2
    case Isa::kAvx2:
      return N_AVX2::view_tables<InstancedView>();
#endif
#if HWY_TARGETS & HWY_SSE4
    case Isa::kSse4:
      return N_SSE4::view_tables<InstancedView>();
#endif
    default:
      return N_SCALAR::view_tables<InstancedView>();
  }
}

}  // namespace tessera::core

#endif  // HWY_ONCE
