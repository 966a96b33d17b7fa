// SPDX-License-Identifier: Apache-2.0
// A bundle of camera rays and the thesis's tests of a triangle against it, one ray at a time: for
// counting, not for speed. Numbers in brackets are sections of the thesis.
//
// Threads. One object per thread; it reads the scene.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "slave/core/camera/camera_rays.h"
#include "slave/core/primitive/triangle/triangle_store.h"

namespace tessera::bench {

inline constexpr std::array<std::uint32_t, 4> kMailboxSizes = {16, 32, 64, 128};

struct ThesisCounts {
  std::uint64_t bundles = 0, steps = 0, front_only = 0, back_only = 0, both = 0;
  std::uint64_t leaves = 0;  // that are not empty
  // Tests of a bundle and a triangle: without mailboxes, with one per triangle (4.4.4), with a
  // hashed table of kMailboxSizes.
  std::uint64_t tests = 0, tests_once = 0;
  std::array<std::uint64_t, 4> tests_hashed{};
  // tests_outside_box: part of `tests`, in leaves whose triangles' box no ray meets. edges:
  // different edges in visited leaves.
  std::uint64_t tests_outside_box = 0, edges = 0;
  // How a test of four rays ends, projection test (5.1).
  std::uint64_t exit_by_distance = 0, exit_inside = 0, full = 0, full_without_distance = 0;
  // decisions: how often it was asked whether a ray passes inside a triangle. The errors: how often
  // a test in float32 answered otherwise than exact arithmetic does.
  std::uint64_t decisions = 0, projection_errors = 0, pluecker_errors = 0;
};

struct Segment {
  double near, far;
  bool is_empty() const { return !(near <= far); }
};

struct Voxel {
  double lower[3], upper[3];
};

class ThesisBundle {
 public:
  // Requires: both outlive it.
  ThesisBundle(const core::TriangleStore& triangles, const core::CameraRays& camera);

  // Takes the edge_px x edge_px rays at a pixel. Returns: whether all go to the same side of each
  // axis.
  bool begin(int x_px, int y_px, int edge_px);
  // Takes the four corner rays alone, of a tile of any size. Returns: as begin().
  bool begin_corners(int x_px, int y_px, int edge_px);

  std::size_t size() const { return direction_.size(); }
  const std::vector<std::size_t>& corners() const { return corners_; }
  double origin(int axis) const { return origin_[axis]; }
  double direction(std::size_t ray, int axis) const {
    return double{direction_[ray][static_cast<std::size_t>(axis)]};
  }
  bool goes_down(int axis) const { return goes_down_[axis]; }
  // Distance along a ray to a plane across an axis.
  double distance(std::size_t ray, int axis, double plane) const {
    return (plane - origin_[axis]) / direction(ray, axis);
  }
  Segment clip(std::size_t ray, const Voxel& voxel) const;
  // t of each ray's nearest hit so far; infinite without one.
  const std::vector<double>& best() const { return best_; }

  // Tests the triangles of a leaf. with_details: edges are counted, and every decision is
  // compared with the exact one.
  void test_leaf(const std::uint32_t* triangles, std::uint32_t count, bool with_details,
                 ThesisCounts& counts);

 private:
  void add(double x, double y);
  bool has_one_side();
  void count_repeats(std::uint32_t triangle, ThesisCounts& counts);
  void test(std::uint32_t triangle, bool with_details, ThesisCounts& counts);

  const core::TriangleStore& triangles_;
  const core::CameraRays& camera_;
  double origin_[3];
  std::vector<std::array<float, 3>> direction_;
  std::vector<std::size_t> corners_;
  std::vector<double> best_;
  bool goes_down_[3] = {};
  // Mailboxes: the last bundle that tested a triangle, and which triangle a slot stands for.
  struct Slot {
    std::uint32_t triangle = 0;
    std::uint64_t bundle = 0;
  };
  std::uint64_t bundle_ = 0;
  std::vector<std::uint64_t> mailbox_;
  std::array<std::vector<Slot>, kMailboxSizes.size()> hashed_;
};

}  // namespace tessera::bench
