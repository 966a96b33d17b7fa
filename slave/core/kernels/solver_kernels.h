// SPDX-License-Identifier: Apache-2.0
// The complete solver of patches of degrees up to 3, by instruction set. Its bits are the same on
// all of them.
//
// Threads. Pure functions.
#pragma once

#include "common/base/isa.h"
#include "slave/core/primitive/patch/cubic_solver_layout.h"

namespace tessera::core {

// Requires: the set is compiled in.
CubicSolverCall cubic_solver(Isa isa);

}  // namespace tessera::core
