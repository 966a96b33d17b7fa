// SPDX-License-Identifier: Apache-2.0
// The instruction sets that kernels are compiled for; stands before Highway in each file of them.
//
// SSSE3 and the Ice Lake variant of AVX-512 have no name in Isa. The fallback is to be HWY_SCALAR with
// every compiler, one lane, and not Highway's emulation of 128 bits.
#pragma once

#ifdef TESSERA_FEW_INSTRUCTION_SETS  // sanitizers, for the time that it takes to compile
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3 | HWY_AVX3_DL)
#else
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#endif
#define HWY_BROKEN_EMU128 1
