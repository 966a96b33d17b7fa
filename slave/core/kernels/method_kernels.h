// SPDX-License-Identifier: Apache-2.0
// Rays through patches by a method of the frame's, by instruction set. They stand apart from the
// kernel table, which knows the usual way alone.
//
// Threads. Pure function.
#pragma once

#include "common/base/isa.h"
#include "slave/core/kernels/method_kernels_layout.h"

namespace tessera::core {

// Requires: the set is compiled in.
MethodTables method_kernels(Isa isa);

}  // namespace tessera::core
