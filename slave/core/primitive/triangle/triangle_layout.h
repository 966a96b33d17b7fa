// SPDX-License-Identifier: Apache-2.0
// Triangles side by side, as the kernels test them.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

namespace tessera::core {

// Corners A, B, C and the numbers of W triangles; NaN and kNoPrimitive where there are fewer.
// Kernels load whole registers of W lanes with aligned loads.
template <int W>
struct alignas(W * sizeof(float)) TriangleBlock {
  float vertex[9][W];
  uint32_t primitive[W];
};

static_assert(sizeof(TriangleBlock<8>) == 320 && sizeof(TriangleBlock<16>) == 640);

}  // namespace tessera::core
