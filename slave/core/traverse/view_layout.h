// SPDX-License-Identifier: Apache-2.0
// The structures as the kernels see them, and the calls that each of them has.
// Fixed-size types only and no functions.
#pragma once

#include <stdint.h>

#include "slave/core/accel/bvh_layout.h"
#include "slave/core/accel/kd_layout.h"
#include "slave/core/ray/packet_layout.h"

namespace tessera::core {

// The structures as the kernels see them; memory of PreparedScene.
// ShapesOf: the blocks of primitives that leaves name (primitive/shapes_layout.h).
template <int W, class ShapesOf>
struct BvhView {
  using Shapes = ShapesOf;
  static constexpr int kWidth = W;
  const BvhNode<W>* nodes;  // root first; null for an empty scene
  Shapes shapes;
  SceneBox box;
};
template <int W, class ShapesOf>
struct KdView {
  using Shapes = ShapesOf;
  static constexpr int kWidth = W;
  const KdNode* nodes;  // root first; null for an empty scene
  // The boxes of the leaves' blocks. Leaves name some of these, whose children are blocks.
  const BvhNode<W>* leaves;
  Shapes shapes;
  SceneBox box;
};

// Entry points for one kind of structure. A ray's answer is the same to the bit from each of them
// and on every instruction set: the primitive that it hits first in exact arithmetic, as far as t
// tells; of hits at equal t the lowest primitive. A ray with a component that is not finite, a zero
// direction, components whose sizes add up to infinity, or limits that are NaN is a miss and
// touches no other ray.
template <class View>
struct ViewKernels {
  void (*closest_ray)(const View& scene, const SingleRay& ray, SingleHit& hit);
  bool (*occluded_ray)(const View& scene, const SingleRay& ray);
  void (*enter_fans)(const View& scene, const FanWindow& window, FanEntry& entry);
  // Rays that are no narrow fan are traced without company.
  void (*closest_fan)(const View& scene, const Fan& rays, const HitArrays& hits);
  uint64_t (*occluded_fan)(const View& scene, const Fan& rays);  // bits of the blocked
  // Sets, for each fan, the bits of its blocked rays. blocked [fans.targets->group_count].
  void (*occluded_fans)(const View& scene, const ShadowFans& fans, uint64_t* blocked);
  // Any number of rays. blocked [rays.packet_count]: bits of the blocked.
  void (*closest_many)(const View& scene, const ManyRays& rays, const HitArrays& hits);
  void (*occluded_many)(const View& scene, const ManyRays& rays, uint64_t* blocked);
};

}  // namespace tessera::core
