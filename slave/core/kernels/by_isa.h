// SPDX-License-Identifier: Apache-2.0
// Picks a constant of what Highway has compiled for one instruction set. This file is included
// behind HWY_ONCE.
//
// The compiler evaluates the constant. A function of the set that is called to make a table would
// be run on processors that do not have the set.
//
// Threads. A macro of pure expressions.
#pragma once

#include "common/base/isa.h"

#define TESSERA_RETURN_CONSTANT(expression)   \
  {                                           \
    static constexpr auto kHere = expression; \
    return kHere;                             \
  }
#if HWY_TARGETS & HWY_AVX3
#define TESSERA_OF_AVX512(expression) \
  case Isa::kAvx512:                  \
    TESSERA_RETURN_CONSTANT(N_AVX3::expression)
#else
#define TESSERA_OF_AVX512(expression)
#endif
#if HWY_TARGETS & HWY_AVX2
#define TESSERA_OF_AVX2(expression) \
  case Isa::kAvx2:                  \
    TESSERA_RETURN_CONSTANT(N_AVX2::expression)
#else
#define TESSERA_OF_AVX2(expression)
#endif
#if HWY_TARGETS & HWY_SSE4
#define TESSERA_OF_SSE4(expression) \
  case Isa::kSse4:                  \
    TESSERA_RETURN_CONSTANT(N_SSE4::expression)
#else
#define TESSERA_OF_SSE4(expression)
#endif

// Returns, from the enclosing function, the value of `expression` in the namespace of `isa`.
// Requires: the set is compiled in.
#define TESSERA_RETURN_OF(isa, expression)          \
  switch (isa) {                                    \
    TESSERA_OF_AVX512(expression)                   \
    TESSERA_OF_AVX2(expression)                     \
    TESSERA_OF_SSE4(expression)                     \
    default:                                        \
      TESSERA_RETURN_CONSTANT(N_SCALAR::expression) \
  }
