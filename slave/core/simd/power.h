// SPDX-License-Identifier: Apache-2.0
// Powers of plain numbers, by the text of power-inl.h, and also for y = 0.
// Threads. Pure functions.
#pragma once

#define TESSERA_PLAIN_TEXT

#include "slave/core/simd/power-inl.h"

namespace tessera::core {

using plain::exp2_of;
using plain::log2_of;

// Requires: x >= 0, y >= 0, both finite. 0 to the power of 0 is 1.
inline float power(float x, float y) { return y == 0 ? 1 : plain::power(x, y); }

}  // namespace tessera::core
