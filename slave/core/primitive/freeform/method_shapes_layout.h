// SPDX-License-Identifier: Apache-2.0
// Scenes with patches as kernels see them where a frame asks for a method of its own: the blocks of
// shapes_layout.h, and what answers for sub-patches.
// Fixed-size types only and no functions.
#pragma once

#include "slave/core/primitive/patch/methods/patch_method_abi.h"
#include "slave/core/primitive/shapes_layout.h"

namespace tessera::core {

template <int W>
struct PatchesByMethod {
  const uint32_t* blocks;
  const TriangleBlock<W>* triangles;
  const SubPatch* parts;  // the items
  const Patch* patches;
  PatchMethodCall method;
};

}  // namespace tessera::core
