// SPDX-License-Identifier: Apache-2.0
// The BSDFs that are computed a packet at a time, compiled once per instruction set by Highway; see
// kernels.cpp.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/bsdf_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/bsdf/bsdfs-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "slave/core/kernels/view_tables.h"

namespace tessera::core {

BsdfKernels bsdf_kernels(Isa isa) { TESSERA_RETURN_OF(isa, bsdf_table()) }

}  // namespace tessera::core

#endif  // HWY_ONCE
