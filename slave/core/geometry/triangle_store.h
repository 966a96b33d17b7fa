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

// Shape: boxes becomes [triangle_count]; a triangle without area, or one that a transform sends
// beyond float32, gets an empty box: it keeps its number and stays out of the tree. Requires:
// validate_scene(scene) is ok.
TriangleStore make_triangle_store(const Scene& scene, std::vector<Bounds3f>& boxes);

}  // namespace tessera::core
