// SPDX-License-Identifier: Apache-2.0
// Scenes with places of shared surfaces as kernels see them where a frame asks for a method of its
// own: the blocks of places_layout.h, and what answers for sub-patches.
// Fixed-size types only and no functions.
#pragma once

#include "slave/core/primitive/patch/methods/patch_method_abi.h"
#include "slave/core/primitive/places_layout.h"

namespace tessera::core {

template <int W>
struct PlacesByMethod : TrianglesAndPlaces<W> {
  PatchMethodCall method;
};

}  // namespace tessera::core
