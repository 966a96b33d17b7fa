// SPDX-License-Identifier: Apache-2.0
// The structures of scenes with patches whose sub-patches a method answers for, and the calls that
// they have. Fixed-size types only and no functions.
#pragma once

#include "slave/core/primitive/freeform/method_shapes_layout.h"
#include "slave/core/primitive/placed/method_places_layout.h"
#include "slave/core/traverse/view_layout.h"

namespace tessera::core {

template <int W>
using MethodView = BvhView<W, PatchesByMethod<W>>;
template <int W>
using MethodPlacesView = BvhView<W, PlacesByMethod<W>>;

// The calls of ViewKernels that there are: all rays are traced one by one.
template <class View>
struct MethodKernels {
  void (*closest_ray)(const View& scene, const SingleRay& ray, SingleHit& hit);
  bool (*occluded_ray)(const View& scene, const SingleRay& ray);
};
struct MethodTables {
  MethodKernels<MethodView<8>> by8;
  MethodKernels<MethodView<16>> by16;
  MethodKernels<MethodPlacesView<8>> placed8;
  MethodKernels<MethodPlacesView<16>> placed16;
};

}  // namespace tessera::core
