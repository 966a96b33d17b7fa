// SPDX-License-Identifier: Apache-2.0
// Cuts triangles at the faces of boxes, for builders of trees.
//
// Threads. Constant; any number of threads.
#pragma once

#include <span>

#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

class TriangleClipper final : public PrimitiveClipper {
 public:
  // Shape: vertices [triangle_count][3 corners][x, y, z]; they outlive it.
  explicit TriangleClipper(std::span<const float> vertices) : vertices_(vertices) {}

  Bounds3f clip(std::uint32_t triangle, const Bounds3f& voxel) const override;

 private:
  std::span<const float> vertices_;
};

}  // namespace tessera::core
