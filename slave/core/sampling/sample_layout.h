// SPDX-License-Identifier: Apache-2.0
// Points of the sample sequence, as the kernels see them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera::core {

inline constexpr int kSamplePoints = 64;

// Shape of all: [kSamplePoints].
struct alignas(64) SamplePoints {
  uint32_t key[kSamplePoints];     // input
  float square[2][kSamplePoints];  // output, in [0, 1)
  int32_t count;
};

}  // namespace tessera::core
