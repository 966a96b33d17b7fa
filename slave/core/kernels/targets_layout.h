// SPDX-License-Identifier: Apache-2.0
// The instruction sets that kernels are compiled for; each kernel file includes this before
// Highway.
//
// SSSE3 and the Ice Lake variant of AVX-512 are left out, since Isa has no names for them. The
// fallback is HWY_SCALAR with every compiler, one lane, and not Highway's emulation of 128 bits.
#pragma once

#ifdef TESSERA_FEW_INSTRUCTION_SETS  // for sanitizers, which would take long to compile
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3 | HWY_AVX3_DL)
#else
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#endif
#define HWY_BROKEN_EMU128 1
