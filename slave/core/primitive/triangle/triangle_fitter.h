// SPDX-License-Identifier: Apache-2.0
// Writes the triangles of a structure's leaves again, with the corners that they have now.
// Threads. fit() may be called by any thread for blocks of its own.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "slave/core/accel/bvh_fit.h"
#include "slave/core/primitive/triangle/triangle_layout.h"

namespace tessera::core {

template <int W>
class TriangleFitter final : public LeafFitter {
 public:
  // `blocks` hold the triangles' numbers, and get their corners. Shape: vertices [triangle_count][3
  // corners][x, y, z], by number. Both outlive it.
  TriangleFitter(std::span<const float> vertices, std::span<TriangleBlock<W>> blocks)
      : vertices_(vertices), blocks_(blocks) {}

  Box4 fit(const LeafRange& leaf) const override;

 private:
  std::span<const float> vertices_;
  std::span<TriangleBlock<W>> blocks_;
};

}  // namespace tessera::core
