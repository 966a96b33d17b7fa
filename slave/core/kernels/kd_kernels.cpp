// SPDX-License-Identifier: Apache-2.0
// Rays through a kd-tree over triangles, compiled once per instruction set by Highway; see
// kernels.cpp.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/kd_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/view_kernels-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "slave/core/kernels/view_tables.h"

namespace tessera::core {

ViewTables<TriangleKd> kd_kernels(Isa isa) { TESSERA_RETURN_OF(isa, view_tables<TriangleKd>()) }

}  // namespace tessera::core

#endif  // HWY_ONCE
