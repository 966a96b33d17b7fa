// SPDX-License-Identifier: Apache-2.0
// An immutable kd-tree over the boxes of primitives.
//
// Threads. Built by build_kd_tree(), then never changed: any number of threads read it without
// locks. PreparedScene owns it; kernels see it as raw pointers in SceneView.
//
// Shapes. nodes(): [node_count], root first, never empty. primitive_refs(): [ref_count], primitive
// numbers, ascending within a leaf.
//
// Invariants, checked by validate():
//   (1) The children of an inner node lie behind it in nodes(), so the tree has no circle, and
//       every node but the root has one parent.
//   (2) Every split lies strictly inside its voxel on its axis.
//   (3) No leaf is deeper than kKdDepthMax.
//   (4) A primitive whose box overlaps the interior of a leaf's voxel is listed there, a listed one
//       at least touches the voxel, and every primitive with a box that is not empty is listed
//       somewhere. A box that only touches a face may be listed on one side alone: traversal pads
//       its intervals, so a ray that reaches the face visits both sides.
//       In a tree whose primitives were cut at voxels, the same holds for their parts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/status.h"
#include "common/math/bounds3.h"
#include "slave/core/accel/kd_layout.h"

namespace tessera::core {

class KdTree {
 public:
  // A tree of one empty leaf with empty bounds.
  KdTree() : nodes_(1, KdNode{kKdLeafTag, {.count = 0}}) {}
  // Takes the arrays over. Requires: nodes not empty.
  KdTree(const Bounds3f& bounds, std::vector<KdNode> nodes,
         std::vector<std::uint32_t> primitive_refs);

  const Bounds3f& bounds() const { return bounds_; }
  std::span<const KdNode> nodes() const { return nodes_; }
  std::span<const std::uint32_t> primitive_refs() const { return primitive_refs_; }
  std::uint64_t memory_bytes() const {
    return nodes_.capacity() * sizeof(KdNode) + primitive_refs_.capacity() * sizeof(std::uint32_t);
  }

  // Walks the whole tree; for tests, quadratic in the worst case. Shape: boxes [primitive_count],
  // empty boxes for primitives that stay out. is_clipped: whether the tree was built with a
  // clipper, so that a box that overlaps a voxel need not be listed. Returns: kInternal naming the
  // first broken invariant and the node.
  Status validate(std::span<const Bounds3f> boxes, bool is_clipped = false) const;

  // Expected cost of a random line through the tree by the surface area heuristic: its steps and
  // its tests of primitives, weighted by the two costs.
  double sah_cost(double cost_traverse, double cost_intersect) const;

 private:
  Bounds3f bounds_;
  std::vector<KdNode> nodes_;
  std::vector<std::uint32_t> primitive_refs_;
};

}  // namespace tessera::core
