// SPDX-License-Identifier: Apache-2.0
// The structure of a scene with patches whose sub-patches a method answers for, and the calls that
// it has. Fixed-size types only and no functions.
#pragma once

#include "slave/core/primitive/freeform/method_shapes_layout.h"
#include "slave/core/traverse/view_layout.h"

namespace tessera::core {

template <int W>
using MethodView = BvhView<W, PatchesByMethod<W>>;

// The calls of ViewKernels that there are: all rays are traced one by one.
template <int W>
struct MethodKernels {
  void (*closest_ray)(const MethodView<W>& scene, const SingleRay& ray, SingleHit& hit);
  bool (*occluded_ray)(const MethodView<W>& scene, const SingleRay& ray);
};
struct MethodTables {
  MethodKernels<8> by8;
  MethodKernels<16> by16;
};

}  // namespace tessera::core
