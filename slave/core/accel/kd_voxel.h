// SPDX-License-Identifier: Apache-2.0
// Voxels of a kd-tree under construction, and how one is split in two.
//
// Threads. Different threads may split different voxels. Those that hold a large share of all
// primitives are split by several threads, in parts that are put together in order: the halves do
// not depend on the number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/bounds3.h"
#include "slave/core/accel/kd_build_config.h"
#include "slave/core/accel/sah_split.h"

namespace tessera::core {

struct VoxelContent {
  std::vector<std::uint32_t> refs;
  std::vector<Bounds3f> parts;  // boxes of the primitives' parts; empty where all are whole
};

struct Voxel {
  Bounds3f bounds;
  VoxelContent content;
  std::uint64_t budget = 0;  // entries that the leaves below may have in all; at least refs.size()
  int depth = 0;

  std::size_t size() const { return content.refs.size(); }
};

class VoxelSplitter {
 public:
  // Requires: the boxes and the configuration outlive it.
  VoxelSplitter(std::span<const Bounds3f> boxes, const KdBuildConfig& config, int thread_count);

  // Returns: the voxel of all primitives that have a box.
  Voxel root() const;
  // Whether the voxel is split by several threads.
  bool is_shared(const Voxel& voxel) const { return voxel.size() >= shared_min_; }
  // Splits the voxel, and frees what it holds: memory stays O(n) per level of depth. Returns:
  // false, with the children untouched, where it should be a leaf.
  bool split(Voxel& voxel, SahScratch& scratch, SahSplit& split, Voxel (&child)[2]) const;

 private:
  template <class Boxes>
  bool split_by(const Boxes& boxes, const Voxel& voxel, SahScratch& scratch, SahSplit& split,
                Voxel (&child)[2]) const;

  const std::span<const Bounds3f> boxes_;
  const KdBuildConfig& config_;
  const int thread_count_;
  const std::size_t shared_min_;
};

}  // namespace tessera::core
