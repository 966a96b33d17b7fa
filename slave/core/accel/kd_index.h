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
#include "slave/core/accel/kd_builder.h"
#include "slave/core/accel/kd_layout.h"
#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

struct KdIndex {
  Bounds3f bounds;            // empty without primitives
  std::vector<KdNode> nodes;  // as in KdTree, but leaves number blocks; empty without primitives

  std::uint64_t memory_bytes() const { return nodes.capacity() * sizeof(KdNode); }
};

// config.block_size: primitives in a block of the set's leaves. Returns: kCancelled;
// kResourceExhausted when indices or memory run out.
Result<KdIndex> build_kd_index(const PrimitiveSet& set, const BuildControl& control,
                               const KdBuildConfig& config = {});

}  // namespace tessera::core
