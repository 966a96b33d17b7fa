// SPDX-License-Identifier: Apache-2.0
// The blocks of primitives that the leaves of a structure name, as the kernels see them: a type for
// each set of kinds that scenes have. Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/primitive/triangle/triangle_layout.h"

namespace tessera::core {

inline constexpr uint32_t kNoBlock = 0xffffffffu;

// Scenes of triangles alone: the number of a block is that of a triangle block.
template <int W>
struct TrianglesOnly {
  const TriangleBlock<W>* triangles;
};

}  // namespace tessera::core
