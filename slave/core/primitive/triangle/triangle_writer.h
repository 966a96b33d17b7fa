// SPDX-License-Identifier: Apache-2.0
// Puts the triangles of a structure's leaves into blocks of W.
//
// Method. A writer either has leaves appended to it or takes in such writers, in turn. The first
// kind lists triangles; corners are copied once, to where they stay.
// Threads. One owner, but for move_in().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "slave/core/accel/primitive_set.h"
#include "slave/core/primitive/triangle/triangle_blocks.h"

namespace tessera::core {

template <int W>
class TriangleWriter final : public LeafWriter {
 public:
  // Shape: vertices [triangle_count][3 corners][x, y, z]; they outlive it.
  explicit TriangleWriter(std::span<const float> vertices) : vertices_(vertices) {}

  LeafRange append(std::span<const std::uint32_t> primitives) override;
  std::unique_ptr<LeafWriter> fresh() const override;
  std::vector<std::uint32_t> make_room(std::span<LeafWriter* const> parts) override;
  void move_in(LeafWriter& part) override;
  void reserve(std::size_t block_count) override { appended_.reserve(block_count * W); }
  std::uint32_t block_count() const override;
  std::span<const std::uint32_t> primitives_of(std::uint32_t block) const override;

  // Returns: all blocks, which the writer no longer has.
  TriangleBlocks<W> take();

 private:
  // Writes the blocks of what was appended.
  void fill(std::span<const std::uint32_t> triangles, TriangleBlock<W>* block) const;

  std::span<const float> vertices_;
  std::vector<std::uint32_t> appended_;  // W for each block; none in lanes that are left
  TriangleBlocks<W> blocks_;
  std::size_t room_ = 0;  // where the blocks move to
};

}  // namespace tessera::core
