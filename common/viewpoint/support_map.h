// SPDX-License-Identifier: Apache-2.0
// The support mapping of a scene: which vertex of its triangles lies farthest along a direction.
// (E. Gilbert, D. Johnson, S. Keerthi, "A Fast Procedure for Computing the Distance Between Complex
// Objects", 1988, section 3.) A camera's framing asks nothing else of a scene's shape.
//
// Answers are exact: boxes of runs of triangles only tell where to look. Reading a mesh is one pass
// over its triangles, however many instances show it; no instance is ever copied. Vertices that no
// triangle names do not count.
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

  bool is_empty() const { return instances_.empty(); }  // no triangle at all

  // The farthest vertex in the world, rounded in doubles only. Requires: !is_empty(), a finite
  // direction.
  Vec3d farthest(Vec3d direction) const;

  // World box of all these vertices; empty where there are none.
  Bounds3f bounds() const;

 private:
  struct Shape {
    std::shared_ptr<const Mesh> mesh;
    Bounds3f box;
    std::vector<Bounds3f> run_boxes;  // of kRunTriangles triangles each, in their order
  };
  struct Best;  // the farthest vertex so far

  static constexpr std::size_t kRunTriangles = 128;

  void search(const Instance& instance, Vec3d direction, Best& best) const;

  std::vector<Shape> shapes_;        // [mesh], those without triangles empty
  std::vector<Instance> instances_;  // that have triangles
};

}  // namespace tessera
