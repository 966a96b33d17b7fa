// SPDX-License-Identifier: Apache-2.0
// Puts what the leaves of a scene with instances hold into blocks: triangles in world space side by
// side, instances by number.
//
// Threads. One owner.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "slave/core/accel/primitive_set.h"
#include "slave/core/primitive/triangle/triangle_writer.h"

namespace tessera::core {

// Primitives of the build are numbered triangles first, then instances.
template <int W>
class InstanceWriter final : public LeafWriter {
 public:
  // Shape: vertices [triangle_count][3 corners][x, y, z]; instances [instance_count]: their numbers
  // in the build, triangle_count and on. Both outlive it.
  InstanceWriter(std::span<const float> vertices, std::span<const std::uint32_t> instances)
      : triangles_(vertices), vertices_(vertices), instances_(instances) {}

  LeafRange append(std::span<const std::uint32_t> primitives) override;
  std::unique_ptr<LeafWriter> fresh() const override;
  std::uint32_t join(LeafWriter& part) override;
  void reserve(std::size_t block_count) override;
  std::uint32_t block_count() const override { return static_cast<std::uint32_t>(blocks_.size()); }
  std::span<const std::uint32_t> primitives_of(std::uint32_t block) const override;

  std::vector<std::uint32_t> take_blocks() { return std::move(blocks_); }
  std::vector<TriangleBlock<W>> take_triangles() { return triangles_.take(); }

 private:
  TriangleWriter<W> triangles_;
  std::span<const float> vertices_;
  std::span<const std::uint32_t> instances_;
  std::vector<std::uint32_t> blocks_;  // as TrianglesAndInstances has them
};

}  // namespace tessera::core
