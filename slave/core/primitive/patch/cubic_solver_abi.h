// SPDX-License-Identifier: Apache-2.0
// The complete solver of degrees up to 3, as it is compiled for each instruction set
// (slave/core/kernels/solver_kernels.cpp). Its bits are the same on all of them.
//
// Threads. Pure functions.
#pragma once

#include "common/base/isa.h"
#include "slave/core/primitive/patch/cubic_solver_layout.h"

namespace tessera::core {

// Requires: the set is compiled in.
CubicSolverCall cubic_solver(Isa isa);
CubicSolversCall cubic_solvers(Isa isa);
QuickAnswersCall quick_answers(Isa isa);

// Those of the widest set that is compiled in and that this processor has.
CubicSolverCall widest_cubic_solver();
CubicSolversCall widest_cubic_solvers();
QuickAnswersCall widest_quick_answers();

}  // namespace tessera::core
