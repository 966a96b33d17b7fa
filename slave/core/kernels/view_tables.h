// SPDX-License-Identifier: Apache-2.0
// The kernels of structures and those of BSDFs, by instruction set. Each group has a file of its
// own, since they take most of the compiler's time.
//
// Threads. Pure functions.
#pragma once

#include "common/base/isa.h"
#include "slave/core/bsdf/lobes_layout.h"
#include "slave/core/kernels/view_tables_layout.h"

namespace tessera::core {

// Requires: the set is compiled in.
ViewTables<TriangleBvh> bvh_kernels(Isa isa);
ViewTables<TriangleKd> kd_kernels(Isa isa);
ViewTables<InstancedView> instance_kernels(Isa isa);
ViewTables<PatchedView> patch_kernels(Isa isa);
BsdfKernels bsdf_kernels(Isa isa);

}  // namespace tessera::core
