// SPDX-License-Identifier: Apache-2.0
// Puts what leaves of more than one kind of primitive hold into blocks: triangles in world space
// side by side, items of the other kind (instances, sub-patches) by number.
//
// Threads. One owner, but for move_in().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "slave/core/accel/primitive_set.h"
#include "slave/core/primitive/triangle/triangle_writer.h"

namespace tessera::core {

// Primitives of the build are numbered triangles first, then items.
template <int W>
class MixedWriter final : public LeafWriter {
 public:
  // Shape: vertices [triangle_count][3 corners][x, y, z]; items [item_count]: their numbers in the
  // build, triangle_count and on. Both outlive it.
  MixedWriter(std::span<const float> vertices, std::span<const std::uint32_t> items)
      : triangles_(vertices), vertices_(vertices), items_(items) {}

  LeafRange append(std::span<const std::uint32_t> primitives) override;
  std::unique_ptr<LeafWriter> fresh() const override;
  std::vector<std::uint32_t> make_room(std::span<LeafWriter* const> parts) override;
  void move_in(LeafWriter& part) override;
  void reserve(std::size_t block_count) override;
  std::uint32_t block_count() const override { return static_cast<std::uint32_t>(blocks_.size()); }
  std::span<const std::uint32_t> primitives_of(std::uint32_t block) const override;

  std::vector<std::uint32_t> take_blocks() { return std::move(blocks_); }
  TriangleBlocks<W> take_triangles() { return triangles_.take(); }

 private:
  TriangleWriter<W> triangles_;
  std::span<const float> vertices_;
  std::span<const std::uint32_t> items_;
  std::vector<std::uint32_t> blocks_;  // as shapes_layout.h has them
  std::size_t room_ = 0;               // where the blocks move to
  std::uint32_t triangle_room_ = 0;    // where those of triangles move to
};

}  // namespace tessera::core
