// SPDX-License-Identifier: Apache-2.0
// A kd-tree whose leaves name blocks of primitives; the kernels traverse it.
//
// Threads. Built once, then never changed.
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/status.h"
#include "common/math/bounds3.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/bvh.h"
#include "slave/core/accel/kd_builder.h"
#include "slave/core/accel/kd_layout.h"
#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

template <int W>
struct KdIndex {
  Bounds3f bounds;  // empty without primitives
  // As in KdTree, but an entry of a leaf is a number of `leaves`; empty without primitives.
  std::vector<KdNode> nodes;
  // The blocks of a leaf, W at a time, with the boxes of what lies of them in the leaf's voxel.
  // Children are numbers of blocks; kBvhNoChild behind the last.
  BvhNodes<W> leaves;

  std::uint64_t memory_bytes() const {
    return nodes.capacity() * sizeof(KdNode) + leaves.capacity() * sizeof(BvhNode<W>);
  }
};

// Makes blocks of W. Returns: kCancelled; kResourceExhausted when indices or memory run out.
template <int W>
Result<KdIndex<W>> build_kd_index(const PrimitiveSet& set, const BuildControl& control,
                                  const KdBuildConfig& config = {});

}  // namespace tessera::core
