// SPDX-License-Identifier: Apache-2.0
// Rays through a kd-tree over sub-patches, compiled by Highway for the wider instruction sets.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#define HWY_BROKEN_EMU128 1
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/bench/kd_patches/kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/kernels/view_kernels-inl.h"
#include "slave/core/primitive/freeform/patch_leaf-inl.h"
#include "tests/bench/kd_patches/kd_patch_view_layout.h"

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "tests/bench/kd_patches/kd_patch_view.h"

namespace tessera::core {

const ViewTables<PatchedKdView>& kd_patch_kernels(Isa isa) {
  TESSERA_RETURN_OF(isa, view_tables<PatchedKdView>())
}

}  // namespace tessera::core

#endif  // HWY_ONCE
