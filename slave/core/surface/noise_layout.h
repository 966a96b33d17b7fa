// SPDX-License-Identifier: Apache-2.0
// Points of gradient noise, as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera::core {

inline constexpr int kNoisePoints = 64;             // of a packet
inline constexpr int kNoiseMax = kNoisePoints * 6;  // all octaves of them
inline constexpr int kNoiseRoom = kNoiseMax + 16;   // registers are loaded and stored whole

struct alignas(64) NoisePoints {
  alignas(64) float at[3][kNoiseRoom];
  alignas(64) uint32_t seed[kNoiseRoom];
  alignas(64) float value[kNoiseRoom];  // made by the kernel
  int count;
};

// Fills in the values of the first `count`, and of some behind them.
using NoiseKernel = void (*)(NoisePoints& points);

}  // namespace tessera::core
