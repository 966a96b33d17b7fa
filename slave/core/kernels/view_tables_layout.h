// SPDX-License-Identifier: Apache-2.0
// The structures that scenes have, by the width of their blocks and the kinds of primitives in
// their leaves. Fixed-size types only and no functions.
#pragma once

#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

namespace tessera::core {

template <int W>
using TriangleBvh = BvhView<W, TrianglesOnly<W>>;
template <int W>
using TriangleKd = KdView<W, TrianglesOnly<W>>;
template <int W>
using InstancedView = BvhView<W, TrianglesAndInstances<W>>;
template <int W>
using PatchedView = BvhView<W, TrianglesAndPatches<W>>;

// The kernels of a structure for blocks of 8 and of 16.
template <template <int> class View>
struct ViewTables {
  ViewKernels<View<8>> by8;
  ViewKernels<View<16>> by16;
};

}  // namespace tessera::core
