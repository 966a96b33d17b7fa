// SPDX-License-Identifier: Apache-2.0
// The complete solver of patches of degrees up to 3, and what answers before it, compiled once per
// instruction set by Highway; see kernels.cpp.
#include "slave/core/kernels/targets_layout.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slave/core/kernels/solver_kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"
#include "slave/core/primitive/patch/cubic_lanes-inl.h"
#include "slave/core/primitive/patch/quick_cubics-inl.h"

#if HWY_ONCE

#include "slave/core/kernels/by_isa.h"
#include "slave/core/kernels/kernel_table.h"
#include "slave/core/primitive/patch/cubic_solver_abi.h"
#include "slave/core/simd/isa_support.h"

namespace tessera::core {

CubicSolverCall cubic_solver(Isa isa){TESSERA_RETURN_OF(isa, solve_cubic)}

CubicSolversCall cubic_solvers(Isa isa){TESSERA_RETURN_OF(isa, solve_cubics)}

QuickAnswersCall quick_answers(Isa isa){TESSERA_RETURN_OF(isa, quick_answers)}

CubicSolverCall widest_cubic_solver() {
  return cubic_solver(widest_isa(cpu_isas() & compiled_isas()));
}

CubicSolversCall widest_cubic_solvers() {
  return cubic_solvers(widest_isa(cpu_isas() & compiled_isas()));
}

QuickAnswersCall widest_quick_answers() {
  return quick_answers(widest_isa(cpu_isas() & compiled_isas()));
}

}  // namespace tessera::core

#endif  // HWY_ONCE
