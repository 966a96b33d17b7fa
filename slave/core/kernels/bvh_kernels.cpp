// SPDX-License-Identifier: Apache-2.0
// Rays through a hierarchy over triangles, compiled once per instruction set by Highway; see kernels.cpp.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/bvh_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/view_kernels-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/view_tables.h"

namespace tessera::core {

ViewTables<TriangleBvh> bvh_kernels(Isa isa) {
  switch (isa) {
#if HWY_TARGETS & HWY_AVX3
    case Isa::kAvx512:
      return N_AVX3::view_tables<TriangleBvh>();
#endif
#if HWY_TARGETS & HWY_AVX2
    case Isa::kAvx2:
      return N_AVX2::view_tables<TriangleBvh>();
#endif
#if HWY_TARGETS & HWY_SSE4
    case Isa::kSse4:
      return N_SSE4::view_tables<TriangleBvh>();
#endif
    default:
      return N_SCALAR::view_tables<TriangleBvh>();
  }
}

}  // namespace tessera::core

#endif  // HWY_ONCE
