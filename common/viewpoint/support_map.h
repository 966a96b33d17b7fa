// SPDX-License-Identifier: Apache-2.0
// The support mapping of a scene: which vertex of its triangles, or point of its surfaces' fine
// control nets (patch_net.h), lies farthest along a direction.
// (E. Gilbert, D. Johnson, S. Keerthi, "A Fast Procedure for Computing the Distance Between Complex
// Objects", 1988, section 3.) A camera's framing asks nothing else of a scene's shape.
//
// Answers are exact for triangles: boxes of runs of them only tell where to look. A freeform
// surface lies between the points of its net, so it is never taken for smaller than it is. Reading
// a mesh is one pass over its triangles, however many instances show it; no instance is ever
// copied. Vertices that no triangle names do not count.
//
// Threads. Immutable after construction; shares the scene's meshes.
#pragma once

#include <memory>
#include <vector>

#include "common/math/bounds3.h"
#include "common/math/vec3d.h"
#include "common/scene/scene.h"

namespace tessera {

class SupportMap {
 public:
  // Requires: a valid scene.
  explicit SupportMap(const Scene& scene);

  bool is_empty() const { return instances_.empty(); }  // neither triangle nor patch

  // The farthest of these points in the world, rounded in doubles only. Requires: !is_empty(), a
  // finite direction.
  Vec3d farthest(Vec3d direction) const;

  // World box of all these points; empty where there are none.
  Bounds3f bounds() const;

 private:
  // The corners of a mesh's triangles, in their order, or the points of a surface's net.
  struct Shape {
    std::shared_ptr<const Mesh> mesh;  // null: a surface
    std::vector<Vec3f> net;
    Bounds3f box;
    std::vector<Bounds3f> run_boxes;  // of kRunPoints points each, in their order

    std::size_t point_count() const { return mesh ? 3 * mesh->triangles.size() : net.size(); }
    Vec3f point(std::size_t i) const {
      return mesh ? mesh->positions[mesh->triangles[i / 3][i % 3]] : net[i];
    }
    void make_boxes();
  };
  struct Placed {
    std::size_t shape;
    Transform object_to_world;
  };
  struct Best;  // the farthest point so far

  static constexpr std::size_t kRunPoints = 3 * 128;

  void search(const Placed& placed, Vec3d direction, Best& best) const;

  std::vector<Shape> shapes_;      // of meshes, then of surfaces; some may be empty
  std::vector<Placed> instances_;  // of shapes that are not
};

}  // namespace tessera
