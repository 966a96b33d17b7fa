// SPDX-License-Identifier: Apache-2.0
// What builders of spatial indices know of primitives: their boxes, how to cut them, and where those
// of a leaf go. No builder knows what a primitive is.
//
// Threads. A clipper is called by any thread of a build, a writer by one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

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
  // Moves the blocks of a fresh writer behind those that are here. Returns: what the numbers of its
  // blocks become greater by.
  virtual std::uint32_t join(LeafWriter& part) = 0;
  // Makes room for so many blocks in all.
  virtual void reserve(std::size_t block_count) = 0;

  virtual std::uint32_t block_count() const = 0;
  // Returns: the primitives of a block, in its order. For validation.
  virtual std::span<const std::uint32_t> primitives_of(std::uint32_t block) const = 0;
};

// What a builder has to know of primitives beside their boxes, to cut them at the faces of voxels.
class PrimitiveClipper {
 public:
  virtual ~PrimitiveClipper() = default;
  // Any thread. Returns: a box around the part of the primitive that is in `voxel`, faces included,
  // and within `voxel`; empty where nothing of it is.
  virtual Bounds3f clip(std::uint32_t primitive, const Bounds3f& voxel) const = 0;
};

// Shape: boxes [primitive_count], finite; a primitive whose box is empty keeps its number and stays out.
// Requires: both outlive the build.
struct PrimitiveSet {
  std::span<const Bounds3f> boxes;
  LeafWriter& leaves;  // empty
  // Primitives from this number on take a leaf each: they cost so much that a box of their own pays.
  std::uint32_t alone_from = 0xffffffffu;
};

}  // namespace tessera::core
