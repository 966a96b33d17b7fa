// SPDX-License-Identifier: Apache-2.0
// The kd-tree over sub-patches as its kernels see it.
// Fixed-size types only and no functions.
#pragma once

#include "slave/core/primitive/shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

namespace tessera::core {

template <int W>
using PatchedKdView = KdView<W, TrianglesAndPatches<W>>;

}  // namespace tessera::core
