// SPDX-License-Identifier: Apache-2.0
// All triangles of a scene version in world space, flattened over instances in the scene's
// numbering.
//
// Threads. Filled once by make_triangle_store(), then read by any thread.
//
// Invariant. A vertex that triangles of one instance share has the same bits in each of them; the
// watertight test relies on it.
#pragma once

#include <cstdint>
#include <vector>

#include "common/math/bounds3.h"
#include "common/scene/scene.h"

namespace tessera::core {

struct TriangleStore {
  std::vector<float> vertices;  // [triangle_count][3 vertices][x, y, z], world units
  // [instance_count + 1] number of the first triangle of each
  std::vector<std::uint64_t> instance_first;
  std::uint64_t degenerate_count = 0;

  std::uint64_t triangle_count() const { return vertices.size() / 9; }
  Vec3f vertex(std::uint64_t triangle, int corner) const {
    const float* p = vertices.data() + triangle * 9 + static_cast<std::uint64_t>(corner) * 3;
    return {p[0], p[1], p[2]};
  }
  // The instance that a triangle belongs to. O(log instances).
  std::uint32_t instance_of(std::uint64_t triangle) const;
};

// Remembers the instance that was asked for last: neighbours on the picture mostly share it.
class InstanceFinder {
 public:
  // Keeps a reference until the next call.
  void begin(const TriangleStore& triangles) {
    triangles_ = &triangles;
    first_ = count_ = 0;
  }

  std::uint32_t of(std::uint64_t triangle) {
    if (triangle - first_ >= count_) find(triangle);
    return instance_;
  }
  // Of the instance that was asked for last.
  std::uint64_t first_triangle() const { return first_; }

 private:
  void find(std::uint64_t triangle);

  const TriangleStore* triangles_ = nullptr;
  std::uint64_t first_ = 0, count_ = 0;  // triangles of instance_
  std::uint32_t instance_ = 0;
};

// Shape: boxes becomes [triangle_count]; a triangle without area, or one that a transform sends
// beyond float32, gets an empty box: it keeps its number and stays out of the tree. Requires:
// validate_scene(scene) is ok.
TriangleStore make_triangle_store(const Scene& scene, std::vector<Bounds3f>& boxes);

}  // namespace tessera::core
