// SPDX-License-Identifier: Apache-2.0
// Builds a kd-tree from boxes by the surface area heuristic (SAH).
//
// Method. MacDonald and Booth, "Heuristics for ray tracing using space subdivision", 1990, with the
// empty-space bonus of Wald and Havran, "On building fast kd-trees for ray tracing, and on doing
// that in O(N log N)", 2006, and, where there is a clipper, their perfect splits: the box of a
// primitive that is in both halves of a voxel is cut anew for each. Planes are tried at the borders
// of bins in voxels of many primitives, and at every face of a box in voxels of few.
//
// Threads. The calling thread and up to thread_count - 1 more. The tree does not depend on their
// number: the top of the tree is split into subtrees by counts alone, and each subtree is built by
// one thread.
#pragma once

#include <span>

#include "common/base/status.h"
#include "common/math/bounds3.h"
#include "slave/core/accel/build_control.h"
#include "slave/core/accel/kd_build_config.h"
#include "slave/core/accel/kd_tree.h"
#include "slave/core/accel/primitive_set.h"

namespace tessera::core {

// Returns: the configuration of the quality build, which takes a good two times as long as the fast
// build. The fast build uses the defaults of KdBuildConfig.
KdBuildConfig quality_build(const PrimitiveClipper& clipper);

// Shape: boxes [primitive_count]; an empty box keeps its number and stays out. Boxes are finite.
// Returns: kCancelled; kResourceExhausted when nodes cannot address the result or memory ran out.
Result<KdTree> build_kd_tree(std::span<const Bounds3f> boxes, const BuildControl& control,
                             const KdBuildConfig& config = {});

}  // namespace tessera::core
