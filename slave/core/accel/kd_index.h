// A kd-tree whose leaves hold blocks of W triangles: what the kernels go through.
//
// Threads. Built once, then never changed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/status.h"
#include "common/math/bounds3.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh_layout.h"
#include "slave/core/accel/kd_builder.h"
#include "slave/core/accel/kd_layout.h"

namespace tessera::core {

template <int W>
struct KdIndex {
  Bounds3f bounds;            // empty without triangles
  std::vector<KdNode> nodes;  // as in KdTree, but leaves number blocks; empty without triangles
  std::vector<TriangleBlock<W>> blocks;

  std::uint64_t memory_bytes() const {
    return nodes.capacity() * sizeof(KdNode) + blocks.capacity() * sizeof(TriangleBlock<W>);
  }
};

// Shape: boxes [triangle_count], an empty one keeps its number and stays out; vertices
// [triangle_count][3][3]; config.block_size is W. Returns: kCancelled; kResourceExhausted when
// indices or memory run out.
template <int W>
Result<KdIndex<W>> build_kd_index(std::span<const Bounds3f> boxes, std::span<const float> vertices,
                                  const BuildControl& control, KdBuildConfig config = {});

}  // namespace tessera::core
