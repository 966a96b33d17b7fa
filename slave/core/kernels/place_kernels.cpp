// SPDX-License-Identifier: Apache-2.0
// Rays through a hierarchy over places of shared surfaces, sub-patches and triangles, compiled once
// per instruction set by Highway; see kernels.cpp.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/place_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/view_kernels-inl.h"
#include "slave/core/primitive/placed/place_leaf-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "slave/core/kernels/place_kernels.h"

namespace tessera::core {

const ViewTables<PlacedView>& place_kernels(Isa isa) {
  TESSERA_RETURN_OF(isa, view_tables<PlacedView>())
}

}  // namespace tessera::core

#endif  // HWY_ONCE
