// SPDX-License-Identifier: Apache-2.0
// Rays through a hierarchy over sub-patches and triangles, compiled once per instruction set by
// Highway; see kernels.cpp.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/patch_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/view_kernels-inl.h"
#include "slave/core/primitive/freeform/patch_leaf-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "slave/core/kernels/view_tables.h"

namespace tessera::core {

ViewTables<PatchedView> patch_kernels(Isa isa) {
  TESSERA_RETURN_OF(isa, view_tables<PatchedView>())
}

}  // namespace tessera::core

#endif  // HWY_ONCE
