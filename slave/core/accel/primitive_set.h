// SPDX-License-Identifier: Apache-2.0
// What builders of spatial indices know of primitives: their boxes, how to cut them, and where the
// primitives of a leaf are written. No builder knows what a primitive is.
//
// Threads. A clipper is called by any thread of a build, a writer by one thread at a time,
// but for move_in().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/math/bounds3.h"

namespace tessera::core {

// Blocks hold primitives as the kernels test them, side by side. A leaf is a run of blocks.
struct LeafRange {
  std::uint32_t first = 0, count = 0;
};

class LeafWriter {
 public:
  virtual ~LeafWriter() = default;

  // Puts the primitives into new blocks behind all others. Returns: those blocks.
  virtual LeafRange append(std::span<const std::uint32_t> primitives) = 0;
  // Returns: an empty writer for the same primitives; each task of a build fills its own.
  virtual std::unique_ptr<LeafWriter> fresh() const = 0;
  // Makes room for the blocks of fresh writers, in turn, behind those that are here. Returns: by
  // how much the numbers of each one's blocks grow.
  virtual std::vector<std::uint32_t> make_room(std::span<LeafWriter* const> parts) = 0;
  // Moves the blocks of such a writer into its room. Different threads may move different ones.
  virtual void move_in(LeafWriter& part) = 0;
  // Reserves memory for this many blocks in all.
  virtual void reserve(std::size_t block_count) = 0;

  virtual std::uint32_t block_count() const = 0;
  // Returns: the primitives of a block, in its order. For validation.
  virtual std::span<const std::uint32_t> primitives_of(std::uint32_t block) const = 0;
};

// Cuts primitives at the faces of voxels, for builders that need more than boxes.
class PrimitiveClipper {
 public:
  virtual ~PrimitiveClipper() = default;
  // May be called by any thread. Returns: a box around the part of the primitive that is in
  // `voxel`, faces included. The box lies within `voxel`; it is empty where no part does.
  virtual Bounds3f clip(std::uint32_t primitive, const Bounds3f& voxel) const = 0;
};

// Shape: boxes [primitive_count], finite; a primitive whose box is empty keeps its number and stays
// out. Requires: boxes and leaves outlive the build.
struct PrimitiveSet {
  std::span<const Bounds3f> boxes;
  LeafWriter& leaves;  // empty
  // Each primitive from this number on takes a leaf of its own: its test costs so much that a box
  // of its own pays.
  std::uint32_t alone_from = 0xffffffffu;
};

}  // namespace tessera::core
