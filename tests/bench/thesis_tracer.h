// SPDX-License-Identifier: Apache-2.0
// The thesis's own ways through a kd-tree, one ray at a time: for counting steps, not for speed.
// Numbers in brackets are sections of the thesis.
//
// Threads. One object per thread; it reads the scene.
#pragma once

#include "slave/core/accel/kd_tree.h"
#include "tests/bench/thesis_bundle.h"

namespace tessera::bench {

enum class Way {
  kMasked,      // every ray has a segment of its own, and takes part where it is not empty (4.2)
  kExtremal,    // the corner rays decide for all rays, against the voxel (4.3.2)
  kOneSegment,  // extremal distances of the corner rays, one segment for all (figure 4.15)
};

// A subtree and its voxel.
struct Subtree {
  std::uint32_t node = 0;
  Voxel voxel{};
  bool is_empty = false;  // there is nothing to go to
};

class ThesisTracer {
 public:
  // Requires: all outlive it.
  ThesisTracer(const core::KdTree& tree, const core::TriangleStore& triangles,
               const core::CameraRays& camera)
      : tree_(tree), bundle_(triangles, camera) {}

  // Traces the bundle of edge_px x edge_px camera rays, a power of two, at a pixel, from a subtree
  // that holds all they meet. A bundle whose rays go to different sides of an axis is traced in
  // quarters. with_details: see ThesisBundle.
  void trace(Way way, int x_px, int y_px, int edge_px, const Subtree& from, bool with_details,
             ThesisCounts& counts);
  // Finds the subtree where a tile's bundles may begin, searched from a subtree that holds all they
  // meet (4.3.3). Adds the steps taken to `steps`. Returns: `from` itself where the rays go to
  // different sides.
  Subtree find_entry(int x_px, int y_px, int edge_px, const Subtree& from, std::uint64_t& steps);
  Subtree root() const;

 private:
  enum class Side { kFront, kBack, kBoth };
  static bool is_leaf(const core::KdNode& node) {
    return (node.tag_and_index & 3u) == core::kKdLeafTag;
  }
  Subtree child(const Subtree& of, bool is_front) const;
  // Decides by the corner rays, against the voxel.
  Side side_of(const Subtree& at) const;
  bool reaches_leaf(const Subtree& at, std::uint64_t& steps) const;
  Subtree search(Subtree at, std::uint64_t& steps) const;
  void trace_masked(const Subtree& from, ThesisCounts& counts);
  void trace_extremal(const Subtree& from, ThesisCounts& counts);
  void trace_one_segment(const Subtree& from, ThesisCounts& counts);
  static void count(Side side, ThesisCounts& counts);
  void test_leaf(const core::KdNode& leaf, ThesisCounts& counts);

  const core::KdTree& tree_;
  ThesisBundle bundle_;
  bool with_details_ = false;
};

}  // namespace tessera::bench
